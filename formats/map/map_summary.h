#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/hash.h"

namespace sightline {

// What a map file is made of, all of it checked.
struct MapSummary {
  std::string format;  // "1.0"
  std::string writer;
  std::string map_id;
  std::string version;
  std::uint64_t release = 0;
  Digest root_digest{};
  Digest model_digest{};
  std::uint64_t file_size = 0;
  std::uint64_t manifest_size = 0;
  std::uint64_t directory_size = 0;
  std::uint32_t tile_count = 0;
  struct Blocks {  // all layers, or the section, of one name
    std::string name;
    bool is_required = false;
    std::uint64_t block_count = 0;
    std::uint64_t row_count = 0;
    std::uint64_t raw_size = 0;
    std::uint64_t stored_size = 0;
  };
  std::vector<Blocks> blocks;  // ascending name
};

}  // namespace sightline
