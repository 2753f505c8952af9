#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/record/fields.h"

// How the bytes of a layer or section are carried in the file.

namespace sightline {

enum class BlockCodec : std::uint8_t { kNone, kZstd };
template <>
inline constexpr auto kNamesOf<BlockCodec> = enum_names("none", "zstd");

struct StoredBlock {
  BlockCodec codec = BlockCodec::kNone;
  std::vector<std::byte> bytes;
};

// Zstandard where that saves at least a sixteenth (and does not pack more than kMostExpansion bytes
// into one), the bytes as they are where it does not. The
// same bytes for the same version of the zstd library.
StoredBlock pack(std::span<const std::byte> raw);
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

}  // namespace sightline
