#include "formats/map/container/packed_block.h"

#include <algorithm>

#include "formats/map/container/map_digests.h"
#include "map_generated.h"

namespace sightline {
namespace {

Error wrong(ErrorCode code, const PackedBlock& block, const char* what) {
  return {code, "block " + block.name + " does not match its " + what};
}

}  // namespace

PackedBlock packed_block(const MapContainer& container, const schema::Block& block) {
  PackedBlock packed;
  packed.name = block.name()->str();
  packed.version = block.version();
  packed.is_required = block.is_required();
  packed.codec = static_cast<BlockCodec>(block.codec());
  packed.row_count = block.row_count();
  packed.raw_size = block.raw_size();
  packed.stored_checksum = block.stored_checksum();
  packed.raw_digest = to_digest(*block.raw_digest());
  packed.stored = located_bytes(container, block);
  return packed;
}

PackedTile packed_tile(const MapContainer& container, const schema::Tile& tile) {
  PackedTile packed{{tile.x(), tile.y()}, to_digest(*tile.digest()), {}};
  for (const schema::Block* layer : *tile.layers()) {
    packed.layers.push_back(packed_block(container, *layer));
  }
  return packed;
}

Digest required_digest(const PackedTile& tile) {
  std::vector<BlockName> required;
  for (const PackedBlock& layer : tile.layers) {
    if (!layer.is_required) continue;
    required.push_back({layer.name, layer.version, layer.row_count, layer.raw_digest});
  }
  return tile_digest(tile.key, required);
}

Digest to_digest(const schema::Digest& digest) {
  Digest bytes{};
  std::copy(digest.bytes()->begin(), digest.bytes()->end(), bytes.begin());
  return bytes;
}

Error wrong_digest(const std::string& what, const std::string& place) {
  return {ErrorCode::kDigestMismatch, what + " does not match its digest", "", place};
}

Result<void> check_zeros(std::span<const std::byte> file, std::uint64_t begin, std::uint64_t end) {
  for (std::uint64_t i = begin; i < end; ++i) {
    if (file[i] == std::byte{0}) continue;
    return Error{ErrorCode::kOutOfBounds, "bytes between two blocks must be zero", "",
                 "byte " + std::to_string(i)};
  }
  return {};
}

Result<RawBytes> checked_bytes(const PackedBlock& block) {
  if (block_checksum(block.stored) != block.stored_checksum) {
    return wrong(ErrorCode::kChecksumMismatch, block, "checksum");
  }
  RawBytes raw(block.stored);
  if (block.codec == BlockCodec::kZstd) {
    SIGHTLINE_ASSIGN(std::vector<std::byte> unpacked, unpack_zstd(block.stored, block.raw_size));
    raw = RawBytes(std::move(unpacked));
  } else if (block.codec != BlockCodec::kNone || block.raw_size != block.stored.size()) {
    return Error{ErrorCode::kBadLayer, "the codec is unknown or the sizes differ"};
  }
  if (sha256(raw.bytes()) != block.raw_digest) {
    return wrong(ErrorCode::kDigestMismatch, block, "digest");
  }
  return raw;
}

}  // namespace sightline
