#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

// What precedes the payload in the envelope of an artifact (artifact.h), whether that lies in
// memory or comes in pieces.

namespace sightline {

inline constexpr std::size_t kChecksumSize = sizeof(std::uint64_t);  // behind the payload
inline constexpr std::size_t kLeastSealed = 4 + kChecksumSize;
// A head is no longer.
inline constexpr std::size_t kLongestHead =
    4 + sizeof(std::uint32_t) + 2 * sizeof(std::uint64_t) + 256;

std::vector<std::byte> head_of(std::string_view name, std::uint32_t version, std::uint64_t size);
bool has_magic(std::span<const std::byte> bytes);

// The size of the head, which lies at the beginning of `bytes`, after its magic was seen;
// `body_size` is that of head and payload. Errors: truncated-file, bad-layer, old-version,
// future-version.
Result<std::size_t> check_head(std::span<const std::byte> bytes, std::uint64_t body_size,
                               std::string_view name, std::uint32_t version);

// truncated-file, bad-magic, checksum-mismatch.
Error too_short_to_be_sealed(std::uint64_t size);
Error not_sealed();
Error damaged_artifact(std::uint64_t body_size);

}  // namespace sightline
