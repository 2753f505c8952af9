#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/map/container/packed_block.h"
#include "formats/surroundings/ndt_map.h"

// The layer "contents" of a tile (schemas/map_format.md): what lies behind it, a second time,
// so that a file that lost its directory still has a list of what it holds.

namespace sightline {

struct ContentsEntry {
  std::string name;  // at most 32 bytes
  std::uint32_t version = 0;
  bool is_required = false;
  BlockCodec codec = BlockCodec::kNone;
  std::uint64_t row_count = 0;
  std::uint64_t offset = 0;  // from the start of the layer "contents"
  std::uint64_t stored_size = 0;
  std::uint64_t raw_size = 0;
  std::uint64_t stored_checksum = 0;
  Digest raw_digest{};
};

struct TileContents {
  TileKey key;
  Digest digest{};  // of the tile
  std::vector<ContentsEntry> layers;
};

inline constexpr std::size_t kLongestContentsName = 32;

// Of all layers of a tile, ascending by name, but those that are derived or whose name is too long.
TileContents contents_of(TileKey key, const Digest& digest, std::span<const PackedBlock> layers);

std::vector<std::byte> encode_contents(const TileContents& contents);

// The layer that begins where the bytes begin, which may be more than it. None where there is no
// such layer or it does not match its checksum.
std::optional<TileContents> decode_contents(std::span<const std::byte> bytes);

}  // namespace sightline
