#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"

// How the payloads of a delta are packed: zstd, where it pays with bytes of the base as prefix.

namespace sightline {

inline constexpr std::uint32_t kRepackLevel = 15;  // as pack() packs the blocks of a map

// The version of zstd that this program runs with, as 10000 major + 100 minor + patch.
std::uint32_t zstd_version();

// One frame that states its content size; the same bytes for the same version of zstd.
std::vector<std::byte> pack_delta(std::span<const std::byte> raw,
                                  std::span<const std::byte> prefix);

// Exactly `size` bytes. Memory: those, and a window of at most 8 MiB. Error: bad-delta.
Result<std::vector<std::byte>> unpack_delta(std::span<const std::byte> packed,
                                            std::span<const std::byte> prefix, std::uint64_t size);

// What a zstd frame says that it holds; 0 where it is none or does not say.
std::uint64_t content_size(std::span<const std::byte> packed);

// The frame that a map's block of these raw bytes is, where it is packed by the same version.
std::vector<std::byte> pack_anew(std::span<const std::byte> raw, std::uint32_t level);

}  // namespace sightline
