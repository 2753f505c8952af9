#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"

// The fixed parts of a delta file (schemas/delta_format.md).

namespace sightline {

inline constexpr std::uint16_t kDeltaMajor = 1;
inline constexpr std::uint16_t kDeltaMinor = 0;
inline constexpr std::size_t kDeltaHeaderSize = 208;
inline constexpr std::size_t kDeltaStepSize = 56;

// Bounds that let apply live in 64 MiB whatever a delta says.
inline constexpr std::uint64_t kLargestStep = std::uint64_t{4} << 20;
inline constexpr std::uint64_t kLargestPrefix = std::uint64_t{4} << 20;
inline constexpr std::uint64_t kLargestRepack = std::uint64_t{2} << 20;  // unpacked
inline constexpr std::uint64_t kMostSteps = std::uint64_t{1} << 18;
inline constexpr std::uint64_t kLargestResult = std::uint64_t{1} << 36;

// A map by what its header says: enough to know a base again.
struct MapIdentity {
  std::uint64_t size = 0;
  Digest root_digest{};
  std::uint64_t header_checksum = 0;
  friend bool operator==(const MapIdentity&, const MapIdentity&) = default;
};

struct DeltaHeader {
  std::uint16_t major = kDeltaMajor;
  std::uint16_t minor = kDeltaMinor;
  std::uint64_t compatible_features = 0;
  std::uint64_t incompatible_features = 0;
  std::uint64_t file_size = 0;
  MapIdentity base;
  std::uint64_t result_size = 0;
  Digest result_root{};
  Digest result_sha256{};
  std::uint64_t step_count = 0;
  std::uint64_t steps_checksum = 0;  // XXH3
  std::uint32_t zstd_version = 0;    // that repacks need; 0 where there are none
  std::uint32_t zstd_level = 0;
};

enum class DeltaStepKind : std::uint8_t {
  kCopy = 1,
  kPlain = 2,
  kPacked = 3,
  kPatch = 4,
  kRepack = 5,
};

struct DeltaStep {
  DeltaStepKind kind = DeltaStepKind::kCopy;
  std::uint64_t size = 0;  // of what it makes
  std::uint64_t base_offset = 0;
  std::uint64_t base_size = 0;
  std::uint64_t packed_size = 0;
  std::uint64_t packed_checksum = 0;  // XXH3
  std::uint64_t checksum = 0;         // XXH3 of what it makes
};

// The file but for its payloads, sizes and checksums filled in from the steps.
std::vector<std::byte> encode_delta_front(DeltaHeader header, std::span<const DeltaStep> steps);

// `front` is the beginning of the file, at least the header where the file has one; `file_size`
// what it really has. Errors: bad-magic, truncated-file, checksum-mismatch, future-version,
// unknown-required-feature, out-of-bounds, too-large.
Result<DeltaHeader> decode_delta_header(std::span<const std::byte> front, std::uint64_t file_size);

// `bytes` are those between header and payloads. Every rule of the format holds afterwards.
// Errors: checksum-mismatch, bad-delta.
Result<std::vector<DeltaStep>> decode_delta_steps(std::span<const std::byte> bytes,
                                                  const DeltaHeader& header);

}  // namespace sightline
