#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/base/result.h"

// How the bytes of a layer or section are carried in the file.

namespace sightline {

enum class BlockCodec : std::uint8_t { kNone, kZstd };

struct StoredBlock {
  BlockCodec codec = BlockCodec::kNone;
  std::vector<std::byte> bytes;
};

// Zstandard where that saves at least a sixteenth (and does not pack more than kMostExpansion bytes
// into one), the bytes as they are where it does not. The
// same bytes for the same version of the zstd library.
StoredBlock pack(std::span<const std::byte> raw);

// Exactly raw_size bytes. Errors: too-large (kLargestBlock, kMostExpansion), bad-layer.
Result<std::vector<std::byte>> unpack_zstd(std::span<const std::byte> stored,
                                           std::uint64_t raw_size);

}  // namespace sightline
