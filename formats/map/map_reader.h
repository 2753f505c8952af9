#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/map/compiled_map.h"

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

// Reads and checks every byte: header, trailer, manifest, directory, padding, the checksum and
// digest of every block, the digests of tiles and map, and every invariant of the artifacts. What
// is optional and unknown is skipped once its checksum holds.
// The error tells the place of the first fault. Errors: those of open_container(); digest-mismatch,
// checksum-mismatch, bad-layer, bad-order, invalid-artifact; of a path also file-not-found,
// cannot-open, cannot-read.
Result<CompiledMap> read_map(const std::filesystem::path& path);
Result<CompiledMap> read_map(std::span<const std::byte> file);

// The same checks, and what was found.
Result<MapSummary> verify_map(const std::filesystem::path& path);
Result<MapSummary> verify_map(std::span<const std::byte> file);

}  // namespace sightline
