#include "formats/map/container/block_codec.h"

#include <zstd.h>

#include <memory>
#include <string>

#include "formats/reader/map_layout.h"

namespace sightline {

StoredBlock pack(std::span<const std::byte> raw) {
  // Slow to write, as quick to read as any level: a map is written once and read by many.
  constexpr int kLevel = 15;
  StoredBlock block;
  // Memory that is not written to takes none: of a large block little is.
  const std::size_t room = ZSTD_compressBound(raw.size());
  const auto packed = std::make_unique_for_overwrite<std::byte[]>(room);
  const std::size_t size = ZSTD_compress(packed.get(), room, raw.data(), raw.size(), kLevel);
  if (ZSTD_isError(size) == 0 && size <= raw.size() - raw.size() / 16 &&
      raw.size() / kMostExpansion <= size) {
    block.codec = BlockCodec::kZstd;
    block.bytes.assign(packed.get(), packed.get() + size);
  } else {
    block.bytes.assign(raw.begin(), raw.end());
  }
  return block;
}

Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> stored,
                                           std::uint64_t raw_size) {
  if (raw_size > kLargestBlock || raw_size / kMostExpansion > stored.size()) {
    return Error{ErrorCode::kTooLarge,
                 std::to_string(stored.size()) + " packed bytes are said to hold " +
                     std::to_string(raw_size),
                 "", ""};
  }
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != raw_size) {
    return Error{ErrorCode::kBadLayer,
                 "the compressed frame does not hold " + std::to_string(raw_size) + " bytes", "",
                 ""};
  }
  std::vector<std::byte> raw(raw_size);
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
  if (ZSTD_isError(size) != 0 || size != raw_size) {
    return Error{ErrorCode::kBadLayer, "zstd cannot read it", "", ""};
  }
  return raw;
}

}  // namespace sightline
