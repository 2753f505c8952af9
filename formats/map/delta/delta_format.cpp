#include "formats/map/delta/delta_format.h"

#include <algorithm>
#include <array>
#include <string>

#include "formats/base/bytes.h"
#include "formats/record/codec.h"

namespace sightline {

SIGHTLINE_FIELDS(MapIdentity, size, root_digest, header_checksum)
// Behind major, minor and the size of the header.
SIGHTLINE_SOME_FIELDS(DeltaHeader, compatible_features, incompatible_features, file_size, base,
                      result_size, result_root, result_sha256, step_count, steps_checksum,
                      zstd_version, zstd_level)
// Behind its kind, which takes eight bytes.
SIGHTLINE_SOME_FIELDS(DeltaStep, size, base_offset, base_size, packed_size, packed_checksum,
                      checksum)

namespace {

// As that of a map, with another letter.
constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'S', 'L', 'D', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kReservedSize = 16;

Error at_byte(ErrorCode code, const std::string& message, std::uint64_t byte) {
  return {code, message, "", "byte " + std::to_string(byte)};
}

void put(ByteWriter& writer, const DeltaStep& step) {
  writer.put(static_cast<std::uint64_t>(step.kind));
  encode(step, writer);
}

DeltaHeader read_fields(std::span<const std::byte> front) {
  ByteReader reader(front.subspan(kMagic.size(), kDeltaHeaderSize - kMagic.size()));
  DeltaHeader header;
  reader.get(header.major);
  reader.get(header.minor);
  (void)reader.get<std::uint32_t>();
  decode(reader, header);
  return header;
}

Result<void> check_start(std::span<const std::byte> front) {
  const std::size_t compared = std::min(front.size(), kMagic.size());
  if (!front.empty() && std::memcmp(front.data(), kMagic.data(), compared) != 0) {
    return at_byte(ErrorCode::kBadMagic,
                   "the file is not a delta, or was damaged by a transfer as text", 0);
  }
  if (front.size() < kDeltaHeaderSize) {
    return at_byte(ErrorCode::kTruncatedFile,
                   concat("found ", front.size(), " bytes, expected at least ", kDeltaHeaderSize),
                   front.size());
  }
  ByteReader reader(front.subspan(kDeltaHeaderSize - 8, 8));
  if (reader.get<std::uint64_t>() != xxh3(front.first(kDeltaHeaderSize - 8))) {
    return at_byte(ErrorCode::kChecksumMismatch, "the header does not match its checksum",
                   kDeltaHeaderSize - 8);
  }
  return {};
}

Result<void> check_sizes(const DeltaHeader& header, std::uint64_t file_size) {
  if (file_size != header.file_size) {
    return at_byte(
        file_size < header.file_size ? ErrorCode::kTruncatedFile : ErrorCode::kOutOfBounds,
        concat("found ", file_size, " bytes, expected ", header.file_size),
        std::min(file_size, header.file_size));
  }
  if (header.step_count > kMostSteps || header.result_size > kLargestResult) {
    return at_byte(ErrorCode::kTooLarge,
                   concat(header.step_count, " steps produce ", header.result_size, " bytes"),
                   header.step_count > kMostSteps ? 160 : 88);
  }
  if (kDeltaHeaderSize + header.step_count * kDeltaStepSize > file_size) {
    return at_byte(ErrorCode::kTruncatedFile, "the steps do not fit into the file", file_size);
  }
  return {};
}

// What a step of its kind may ask for; what does not apply must be 0.
bool is_allowed(const DeltaStep& step) {
  const bool has_base = step.base_size > 0;
  const bool has_payload = step.packed_size > 0 && step.packed_size <= kLargestStep;
  switch (step.kind) {
    case DeltaStepKind::kCopy:
      return step.base_size == step.size && step.packed_size == 0 && step.packed_checksum == 0;
    case DeltaStepKind::kPlain:
      return !has_base && step.base_offset == 0 && step.packed_size == step.size;
    case DeltaStepKind::kPacked:
      return !has_base && step.base_offset == 0 && has_payload;
    case DeltaStepKind::kPatch:
    case DeltaStepKind::kRepack:
      return has_base && step.base_size <= kLargestPrefix && has_payload;
  }
  return false;
}

Result<void> check_step(const DeltaStep& step, const DeltaHeader& header, std::uint64_t copied_to,
                        std::uint64_t byte) {
  const bool is_sized = step.size > 0 && step.size <= kLargestStep;
  const bool is_inside =
      step.base_offset <= header.base.size && step.base_size <= header.base.size - step.base_offset;
  if (!is_sized || !is_inside || !is_allowed(step)) {
    return at_byte(ErrorCode::kBadDelta, "a step has fields that its kind does not allow", byte);
  }
  if (step.kind == DeltaStepKind::kCopy && step.base_offset < copied_to) {
    return at_byte(ErrorCode::kBadDelta, "copies must ascend in the base", byte);
  }
  if (step.kind == DeltaStepKind::kRepack && header.zstd_version == 0) {
    return at_byte(ErrorCode::kBadDelta, "the header lacks the parameters for packing", byte);
  }
  return {};
}

}  // namespace

std::vector<std::byte> encode_delta_front(DeltaHeader header, std::span<const DeltaStep> steps) {
  ByteWriter step_bytes;
  header.step_count = steps.size();
  header.file_size = kDeltaHeaderSize + steps.size() * kDeltaStepSize;
  for (const DeltaStep& step : steps) {
    put(step_bytes, step);
    header.file_size += step.packed_size;
  }
  header.steps_checksum = xxh3(step_bytes.bytes());
  constexpr std::array<std::uint8_t, kReservedSize> kReserved{};
  ByteWriter writer = written(kMagic, header.major, header.minor,
                              static_cast<std::uint32_t>(kDeltaHeaderSize), header, kReserved);
  writer.put(xxh3(writer.bytes()));
  SIGHTLINE_CHECK(writer.bytes().size() == kDeltaHeaderSize);
  writer.append(step_bytes.bytes().data(), step_bytes.bytes().size());
  return writer.take();
}

Result<DeltaHeader> decode_delta_header(std::span<const std::byte> front, std::uint64_t file_size) {
  SIGHTLINE_TRY(check_start(front));
  const DeltaHeader header = read_fields(front);
  if (header.major != kDeltaMajor) {
    return at_byte(
        header.major > kDeltaMajor ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
        concat("a delta of format ", header.major, ".", header.minor, ", this program reads 1.x"),
        8);
  }
  if (header.incompatible_features != 0) {
    return at_byte(ErrorCode::kUnknownRequiredFeature,
                   "required features are unknown to this program", 24);
  }
  SIGHTLINE_TRY(check_sizes(header, file_size));
  return header;
}

Result<std::vector<DeltaStep>> decode_delta_steps(std::span<const std::byte> bytes,
                                                  const DeltaHeader& header) {
  SIGHTLINE_CHECK(bytes.size() == header.step_count * kDeltaStepSize);
  if (xxh3(bytes) != header.steps_checksum) {
    return at_byte(ErrorCode::kChecksumMismatch, "the steps do not match their checksum",
                   kDeltaHeaderSize);
  }
  ByteReader reader(bytes);
  std::vector<DeltaStep> steps(header.step_count);
  std::uint64_t made = 0;
  std::uint64_t copied_to = 0;
  std::uint64_t payload_end = kDeltaHeaderSize + bytes.size();
  for (DeltaStep& step : steps) {
    const std::uint64_t byte = kDeltaHeaderSize + reader.offset();
    const auto kind = reader.get<std::uint64_t>();  // with the 7 zeros that follow it
    step.kind = static_cast<DeltaStepKind>(kind);
    decode(reader, step);
    if (kind > 0xff) return at_byte(ErrorCode::kBadDelta, "a step of an unknown kind", byte);
    SIGHTLINE_TRY(check_step(step, header, copied_to, byte));
    if (step.kind == DeltaStepKind::kCopy) copied_to = step.base_offset + step.base_size;
    made += step.size;
    payload_end += step.packed_size;
  }
  if (made != header.result_size || payload_end != header.file_size) {
    return at_byte(ErrorCode::kBadDelta,
                   concat("the steps produce ", made, " bytes from a delta of ", payload_end,
                          ", expected ", header.result_size, " and ", header.file_size),
                   kDeltaHeaderSize);
  }
  return steps;
}

}  // namespace sightline
