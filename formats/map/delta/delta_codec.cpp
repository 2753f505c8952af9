#include "formats/map/delta/delta_codec.h"

#include <zstd.h>

#include <algorithm>
#include <bit>
#include <memory>

#include "formats/base/check.h"
#include "formats/map/delta/delta_format.h"

namespace sightline {
namespace {

constexpr int kLevel = 15;
constexpr int kSmallestWindowLog = 10;
constexpr int kLargestWindowLog = 23;  // 8 MiB: a prefix and a step, both of the largest size

struct FreeCompressor {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};
struct FreeDecompressor {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

bool is_good(std::size_t result) { return ZSTD_isError(result) == 0; }

}  // namespace

std::uint32_t zstd_version() { return ZSTD_versionNumber(); }

std::vector<std::byte> pack_delta(std::span<const std::byte> raw,
                                  std::span<const std::byte> prefix) {
  const std::unique_ptr<ZSTD_CCtx, FreeCompressor> context(ZSTD_createCCtx());
  SIGHTLINE_CHECK(context != nullptr);
  const int window_log = std::clamp(static_cast<int>(std::bit_width(raw.size() + prefix.size())),
                                    kSmallestWindowLog, kLargestWindowLog);
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel)));
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, window_log)));
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_refPrefix(context.get(), prefix.data(), prefix.size())));
  std::vector<std::byte> packed(ZSTD_compressBound(raw.size()));
  const std::size_t size =
      ZSTD_compress2(context.get(), packed.data(), packed.size(), raw.data(), raw.size());
  SIGHTLINE_CHECK(is_good(size));
  packed.resize(size);
  return packed;
}

Result<std::vector<std::byte>> unpack_delta(std::span<const std::byte> packed,
                                            std::span<const std::byte> prefix, std::uint64_t size) {
  if (content_size(packed) != size) {
    return Error{ErrorCode::kBadDelta, "a frame does not hold " + std::to_string(size) + " bytes"};
  }
  const std::unique_ptr<ZSTD_DCtx, FreeDecompressor> context(ZSTD_createDCtx());
  SIGHTLINE_CHECK(context != nullptr);
  SIGHTLINE_CHECK(
      is_good(ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindowLog)));
  SIGHTLINE_CHECK(is_good(ZSTD_DCtx_refPrefix(context.get(), prefix.data(), prefix.size())));
  std::vector<std::byte> raw(size);
  const std::size_t made =
      ZSTD_decompressDCtx(context.get(), raw.data(), raw.size(), packed.data(), packed.size());
  if (!is_good(made) || made != size) {
    return Error{ErrorCode::kBadDelta, "zstd cannot read a frame"};
  }
  return raw;
}

std::uint64_t content_size(std::span<const std::byte> packed) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  return size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ? 0 : size;
}

std::vector<std::byte> pack_anew(std::span<const std::byte> raw, std::uint32_t level) {
  std::vector<std::byte> packed(ZSTD_compressBound(raw.size()));
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), static_cast<int>(level));
  SIGHTLINE_CHECK(is_good(size));
  packed.resize(size);
  return packed;
}

}  // namespace sightline
