#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/ndt_map.h"

// Puts a file together from its parts, knowing nothing of what they mean.

namespace sightline {

struct BlockParts {
  std::string name;
  std::uint32_t version = 1;
  bool is_required = true;
  std::uint64_t row_count = 0;
  bool may_compress = true;
  std::vector<std::byte> raw;
};

struct TileParts {
  TileKey key;
  std::vector<BlockParts> layers;  // ascending name
};

struct FeatureParts {
  std::uint8_t bit = 0;
  bool is_required = false;
  std::string name;
};

struct ContainerParts {
  std::vector<std::byte> manifest;
  std::vector<TileParts> tiles;      // ascending key
  std::vector<BlockParts> sections;  // ascending name
  std::vector<FeatureParts> features;
};

// Header, manifest, blocks in order, directory, trailer. The same parts give the same bytes.
std::vector<std::byte> assemble(const ContainerParts& parts);

}  // namespace sightline
