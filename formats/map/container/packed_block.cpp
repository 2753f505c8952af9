#include "formats/map/container/packed_block.h"

#include <algorithm>

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
  std::copy(block.raw_digest()->bytes()->begin(), block.raw_digest()->bytes()->end(),
            packed.raw_digest.begin());
  packed.stored = located_bytes(container, block);
  return packed;
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
