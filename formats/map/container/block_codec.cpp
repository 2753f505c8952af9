#include "formats/map/container/block_codec.h"

#include <zstd.h>

#include <memory>
#include <string>

#include "formats/reader/map_layout.h"

namespace sightline {

StoredBlock pack(std::span<const std::byte> raw) {
  StoredBlock block;
  // Memory that is not written to takes none: of a large block little is.
  const std::size_t room = ZSTD_compressBound(raw.size());
  const auto packed = std::make_unique_for_overwrite<std::byte[]>(room);
  const std::size_t size = ZSTD_compress(packed.get(), room, raw.data(), raw.size(), kPackLevel);
  if (ZSTD_isError(size) == 0 && is_worth_packing(raw.size(), size)) {
    block.codec = BlockCodec::kZstd;
    block.bytes.assign(packed.get(), packed.get() + size);
  } else {
    block.bytes.assign(raw.begin(), raw.end());
  }
  return block;
}

bool is_worth_packing(std::uint64_t raw_size, std::uint64_t packed_size) {
  return packed_size <= raw_size - raw_size / 16 && raw_size / kMostExpansion <= packed_size;
}

Error unreadable_block() { return {ErrorCode::kBadLayer, "zstd cannot read it"}; }

Result<void> check_packed_size(std::span<const std::byte> beginning, std::uint64_t stored_size,
                               std::uint64_t raw_size) {
  if (raw_size > kLargestBlock || raw_size / kMostExpansion > stored_size) {
    return Error{
        ErrorCode::kTooLarge,
        std::to_string(stored_size) + " packed bytes are said to hold " + std::to_string(raw_size)};
  }
  if (ZSTD_getFrameContentSize(beginning.data(), beginning.size()) != raw_size) {
    return Error{ErrorCode::kBadLayer,
                 "the compressed frame does not hold " + std::to_string(raw_size) + " bytes"};
  }
  return {};
}

Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> stored,
                                           std::uint64_t raw_size) {
  SIGHTLINE_TRY(check_packed_size(stored, stored.size(), raw_size));
  std::vector<std::byte> raw(raw_size);
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
  if (ZSTD_isError(size) != 0 || size != raw_size) return unreadable_block();
  return raw;
}

}  // namespace sightline
