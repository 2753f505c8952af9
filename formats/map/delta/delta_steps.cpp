#include "formats/map/delta/delta_steps.h"

#include <algorithm>
#include <string>

#include "formats/map/delta/delta_codec.h"

namespace sightline {
namespace {

// The base's frame unpacked is the prefix; what comes out is packed as the map has it.
Result<std::vector<std::byte>> repacked(const DeltaStep& step, std::uint32_t level,
                                        const std::vector<std::byte>& base,
                                        const std::vector<std::byte>& payload) {
  const std::uint64_t prefix_size = content_size(base);
  const std::uint64_t raw_size = content_size(payload);
  if (prefix_size > kLargestRepack || raw_size > kLargestRepack) {
    return Error{ErrorCode::kBadDelta, "a layer is too large to be packed anew"};
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> prefix, unpack_delta(base, {}, prefix_size));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> raw, unpack_delta(payload, prefix, raw_size));
  std::vector<std::byte> bytes = pack_anew(raw, level);
  if (bytes.size() > step.size) {
    return Error{ErrorCode::kBadDelta, "a layer packed anew is larger than it should be"};
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
  const bool packs_otherwise =
      header->zstd_version != 0 &&
      (header->zstd_version != zstd_version() || header->zstd_level != kRepackLevel);
  if (packs_otherwise) {
    return Error{ErrorCode::kUnknownRequiredFeature,
                 "the delta packs layers with zstd " + std::to_string(header->zstd_version) +
                     ", this program has " + std::to_string(zstd_version()) +
                     "; one made with --portable works",
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
               "a step does not make what it should; the base is damaged or another one",
               base.path().string(), "byte " + std::to_string(step.base_offset)};
}

}  // namespace sightline
