#include "formats/map/container/zstd_frame.h"

#include <zstd.h>

#include "formats/base/check.h"
#include "formats/base/concat.h"
#include "formats/base/zstd_memory.h"
#include "formats/reader/map_layout.h"

namespace sightline {

bool is_worth_packing(std::uint64_t raw_size, std::uint64_t packed_size) {
  return packed_size <= raw_size - raw_size / 16 && raw_size / kMostExpansion <= packed_size;
}

Error unreadable_block() { return {ErrorCode::kBadLayer, "zstd cannot unpack it"}; }

Result<void> check_packed_size(std::span<const std::byte> beginning, std::uint64_t stored_size,
                               std::uint64_t raw_size) {
  if (raw_size > kLargestBlock || raw_size / kMostExpansion > stored_size) {
    return Error{ErrorCode::kTooLarge,
                 concat(stored_size, " packed bytes cannot unpack to ", raw_size)};
  }
  if (ZSTD_getFrameContentSize(beginning.data(), beginning.size()) != raw_size) {
    return Error{ErrorCode::kBadLayer,
                 concat("the compressed frame does not unpack to ", raw_size, " bytes")};
  }
  return {};
}

Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> stored,
                                           std::uint64_t raw_size) {
  SIGHTLINE_TRY(check_packed_size(stored, stored.size(), raw_size));
  std::vector<std::byte> raw(raw_size);
  const std::size_t size =
      with_memory(ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size()));
  if (ZSTD_isError(size) != 0 || size != raw_size) return unreadable_block();
  return raw;
}

std::vector<std::byte> zstd_frame(std::span<const std::byte> bytes) {
  std::vector<std::byte> frame(ZSTD_compressBound(bytes.size()));
  const std::size_t size = with_memory(
      ZSTD_compress(frame.data(), frame.size(), bytes.data(), bytes.size(), kPackLevel));
  SIGHTLINE_CHECK(ZSTD_isError(size) == 0);
  frame.resize(size);
  return frame;
}

Result<std::vector<std::byte>> bytes_of_frame(std::span<const std::byte> frame,
                                              std::uint64_t most) {
  const std::uint64_t size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size > most) return unreadable_block();  // also where the frame does not state it
  return unpack_zstd(frame, size);
}

}  // namespace sightline
