#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// Of Zstandard: slow to write, as quick to read as any: a map is written once and read by many.
inline constexpr int kPackLevel = 15;
[[nodiscard]] bool is_worth_packing(std::uint64_t raw_size, std::uint64_t packed_size);

// Exactly raw_size bytes. Errors: too-large (kLargestBlock, kMostExpansion), bad-layer.
Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> stored,
                                           std::uint64_t raw_size);
// What it checks before it takes memory, of the first bytes (18 at most) of `stored_size`.
Result<void> check_packed_size(std::span<const std::byte> beginning, std::uint64_t stored_size,
                               std::uint64_t raw_size);
Error unreadable_block();
// Zstandard, as pack() does it, whether or not that saves anything.
std::vector<std::byte> zstd_frame(std::span<const std::byte> bytes);
// Of a frame that states its size, which is at most `most`. Errors: bad-layer, too-large.
Result<std::vector<std::byte>> bytes_of_frame(std::span<const std::byte> frame, std::uint64_t most);

}  // namespace sightline
