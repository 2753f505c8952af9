#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/grid/cell_key.h"
#include "formats/map/container/zstd_frame.h"
#include "formats/reader/map_container.h"
#include "formats/record/fields.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {
namespace schema {
struct Digest;
}  // namespace schema

// How the bytes of a layer or section are carried in the file.

// The last two are of maps that keep only what their promise needs.
enum class BlockCodec : std::uint8_t { kNone, kZstd, kNds, kColumns };
template <>
inline constexpr auto kNamesOf<BlockCodec> = enum_names("none", "zstd", "nds", "columns");

struct StoredBlock {
  BlockCodec codec = BlockCodec::kNone;
  std::vector<std::byte> bytes;
};

// Zstandard where that saves at least a sixteenth (and does not pack more than kMostExpansion bytes
// into one), the bytes as they are where it does not. The
// same bytes for the same version of the zstd library.
StoredBlock pack(std::span<const std::byte> raw);
// What was packed by any codec but "none". Errors: those of unpack_zstd().
Result<std::vector<std::byte>> unpack(BlockCodec codec, std::span<const std::byte> stored,
                                      std::uint64_t row_count, std::uint64_t raw_size);

// A block as it lies in a file, and what its entry says of it.
struct PackedBlock {
  std::string name;
  std::uint32_t version = 1;
  bool is_required = true;
  BlockCodec codec = BlockCodec::kNone;
  std::uint64_t row_count = 0;
  std::uint64_t raw_size = 0;
  std::uint64_t stored_checksum = 0;
  Digest raw_digest{};
  std::span<const std::byte> stored;
};

// A block that the directory names; its bytes are not checked.
PackedBlock packed_block(const MapContainer& container, const schema::Block& block);

struct PackedTile {
  TileKey key;
  Digest digest{};
  std::vector<PackedBlock> layers;
};

// A tile that the directory names; its bytes are not checked.
PackedTile packed_tile(const MapContainer& container, const schema::Tile& tile);

// What the digest of a tile is by the entries of its required layers.
Digest required_digest(const PackedTile& tile);

Digest to_digest(const schema::Digest& digest);

Error wrong_digest(const std::string& what, const std::string& place);

// Whether all bytes from one place in a file to another are zero. Error: out-of-bounds, at the
// first that is not.
Result<void> check_zeros(std::span<const std::byte> file, std::uint64_t begin, std::uint64_t end);

// What is stored, or what it was unpacked to.
class RawBytes {
 public:
  explicit RawBytes(std::span<const std::byte> stored) : bytes_(stored) {}
  explicit RawBytes(std::vector<std::byte> unpacked)
      : unpacked_(std::move(unpacked)), bytes_(unpacked_) {}
  RawBytes(RawBytes&&) = default;
  RawBytes& operator=(RawBytes&&) = default;
  RawBytes(const RawBytes&) = delete;
  RawBytes& operator=(const RawBytes&) = delete;
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> unpacked_;  // moves keep its bytes where they are
  std::span<const std::byte> bytes_;
};

// Checks the stored bytes against their checksum, unpacks them and checks the raw bytes against
// their digest. Errors: checksum-mismatch, digest-mismatch, bad-layer, too-large; also where the
// codec is unknown.
Result<RawBytes> checked_bytes(const PackedBlock& block);

// How digests nest: blocks in tiles, tiles and sections in the map (schemas/map_format.md). Only
// what is required counts, so that optional layers can be dropped without changing any digest.

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
