#include "formats/map/delta/delta_steps.h"

#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "formats/base/check.h"
#include "formats/base/zstd_memory.h"
#include "formats/map/delta/delta_format.h"

namespace sightline {
namespace {

// The base's frame unpacked is the prefix; what comes out is packed as the map has it.
Result<std::vector<std::byte>> repacked(const DeltaStep& step, std::uint32_t level,
                                        const std::vector<std::byte>& base,
                                        const std::vector<std::byte>& payload) {
  const std::uint64_t prefix_size = content_size(base);
  const std::uint64_t raw_size = content_size(payload);
  if (prefix_size > kLargestRepack || raw_size > kLargestRepack) {
    return Error{ErrorCode::kBadDelta, "a layer is too large to be packed again"};
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> prefix, unpack_delta(base, {}, prefix_size));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> raw, unpack_delta(payload, prefix, raw_size));
  std::vector<std::byte> bytes = pack_anew(raw, level);
  if (bytes.size() > step.size) {
    return Error{ErrorCode::kBadDelta, "a layer that was packed again is larger than expected"};
  }
  bytes.resize(step.size);
  return bytes;
}

Result<std::vector<std::byte>> bytes_of(const OpenedDelta& delta, const PieceReader& base,
                                        const DeltaStep& step, std::uint64_t payload_offset) {
  Result<std::vector<std::byte>> old = base.read(step.base_offset, step.base_size);
  if (!old || step.kind == DeltaStepKind::kCopy) return old;
  SIGHTLINE_ASSIGN(std::vector<std::byte> payload,
                   delta.file.read(payload_offset, step.packed_size));
  if (xxh3(payload) != step.packed_checksum) {
    return Error{ErrorCode::kChecksumMismatch, "a payload does not match its checksum"};
  }
  if (step.kind == DeltaStepKind::kPlain) return payload;
  if (step.kind == DeltaStepKind::kRepack) {
    return repacked(step, delta.header.zstd_level, *old, payload);
  }
  return unpack_delta(payload, *old, step.size);
}

Error failure(ErrorCode code, const std::filesystem::path& path, const char* what, int number) {
  return {code, concat(what, ": ", std::strerror(number)), path.string()};
}

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

Result<OpenedDelta> open_delta(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(PieceReader file, PieceReader::open(path));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> front,
                   file.read(0, std::min<std::uint64_t>(file.size(), kDeltaHeaderSize)));
  const Result<DeltaHeader> header = decode_delta_header(front, file.size());
  if (!header) return in_file(header.error(), path.string());
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                   file.read(kDeltaHeaderSize, header->step_count * kDeltaStepSize));
  Result<std::vector<DeltaStep>> steps = decode_delta_steps(bytes, *header);
  if (!steps) return in_file(steps.error(), path.string());
  if (header->zstd_version != 0 &&
      (header->zstd_version != zstd_version() || header->zstd_level != kRepackLevel)) {
    return Error{ErrorCode::kUnknownRequiredFeature,
                 concat("the delta packs layers with zstd ", header->zstd_version,
                        ", this program uses ", zstd_version(), "; make the delta with --portable"),
                 path.string(), "byte 176"};
  }
  return OpenedDelta{std::move(file), *header, std::move(*steps)};
}

Result<std::vector<std::byte>> make_step(const OpenedDelta& delta, const PieceReader& base,
                                         const DeltaStep& step, std::uint64_t payload_offset) {
  Result<std::vector<std::byte>> bytes = bytes_of(delta, base, step, payload_offset);
  if (!bytes) {
    Error error = in_file(bytes.error(), delta.file.path().string());
    if (error.place.empty()) error.place = "byte " + std::to_string(payload_offset);
    return error;
  }
  if (xxh3(*bytes) == step.checksum) return bytes;
  return Error{ErrorCode::kDigestMismatch,
               "a step does not produce the expected bytes: the base is damaged or is another map",
               base.path().string(), "byte " + std::to_string(step.base_offset)};
}

Result<PieceReader> PieceReader::open(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RegularFile file, open_regular_file(path.string()));
  return PieceReader(path, std::move(file));
}

Result<std::vector<std::byte>> PieceReader::read(std::uint64_t offset, std::uint64_t size) const {
  std::vector<std::byte> bytes(size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(file_.descriptor.number(), bytes.data() + done,
                                  bytes.size() - done, static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(ErrorCode::kCannotRead, path_, "cannot read", errno);
    if (count == 0) {
      return Error{ErrorCode::kTruncatedFile, "the file became shorter", path_.string(),
                   "byte " + std::to_string(offset + done)};
    }
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

std::uint32_t zstd_version() { return ZSTD_versionNumber(); }

std::vector<std::byte> pack_delta(std::span<const std::byte> raw,
                                  std::span<const std::byte> prefix) {
  const std::unique_ptr<ZSTD_CCtx, FreeCompressor> context(with_memory(ZSTD_createCCtx()));
  const int window_log = std::clamp(static_cast<int>(std::bit_width(raw.size() + prefix.size())),
                                    kSmallestWindowLog, kLargestWindowLog);
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel)));
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, window_log)));
  SIGHTLINE_CHECK(is_good(ZSTD_CCtx_refPrefix(context.get(), prefix.data(), prefix.size())));
  std::vector<std::byte> packed(ZSTD_compressBound(raw.size()));
  const std::size_t size = with_memory(
      ZSTD_compress2(context.get(), packed.data(), packed.size(), raw.data(), raw.size()));
  SIGHTLINE_CHECK(is_good(size));
  packed.resize(size);
  return packed;
}

Result<std::vector<std::byte>> unpack_delta(std::span<const std::byte> packed,
                                            std::span<const std::byte> prefix, std::uint64_t size) {
  if (content_size(packed) != size) {
    return Error{ErrorCode::kBadDelta,
                 "a frame does not unpack to " + std::to_string(size) + " bytes"};
  }
  const std::unique_ptr<ZSTD_DCtx, FreeDecompressor> context(with_memory(ZSTD_createDCtx()));
  SIGHTLINE_CHECK(
      is_good(ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindowLog)));
  SIGHTLINE_CHECK(is_good(ZSTD_DCtx_refPrefix(context.get(), prefix.data(), prefix.size())));
  std::vector<std::byte> raw(size);
  const std::size_t made = with_memory(
      ZSTD_decompressDCtx(context.get(), raw.data(), raw.size(), packed.data(), packed.size()));
  if (!is_good(made) || made != size) {
    return Error{ErrorCode::kBadDelta, "zstd cannot unpack a frame"};
  }
  return raw;
}

std::uint64_t content_size(std::span<const std::byte> packed) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  return size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ? 0 : size;
}

std::vector<std::byte> pack_anew(std::span<const std::byte> raw, std::uint32_t level) {
  std::vector<std::byte> packed(ZSTD_compressBound(raw.size()));
  const std::size_t size = with_memory(
      ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), static_cast<int>(level)));
  SIGHTLINE_CHECK(is_good(size));
  packed.resize(size);
  return packed;
}

}  // namespace sightline
