#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/surroundings/ndt_map.h"

// How digests nest: blocks in tiles, tiles and sections in the map (schemas/map_format.md). Only
// what is required counts, so that optional layers can be dropped without changing any digest.

namespace sightline {

struct BlockName {
  std::string name;
  std::uint32_t version = 0;
  std::uint64_t row_count = 0;
  Digest raw_digest{};
};

Digest tile_digest(TileKey key, const std::vector<BlockName>& required_layers);

Digest root_digest(const Digest& manifest, std::uint64_t incompatible_features,
                   const std::vector<Digest>& tiles,
                   const std::vector<BlockName>& required_sections);

}  // namespace sightline
