#pragma once

#include <cstdint>

#include "formats/base/bytes.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/base/result.h"
#include "formats/map/container/packed_block.h"

// Blocks that memory should not hold whole.

namespace sightline {

struct BlockInPieces {
  BlockCodec codec = BlockCodec::kNone;
  StoredBytes bytes;
};

// So many bytes are in memory beside those that zstd may still refer to, some mebibytes.
inline constexpr std::uint64_t kPackedPiece = std::uint64_t{1} << 20;

// As pack(), and of no more than kPackedPiece bytes the same, bit for bit; of more, the same for
// the same version of the zstd library. Errors: cannot-read, disk-full, cannot-write (temporary
// files), out-of-memory.
Result<BlockInPieces> pack_in_pieces(const StoredBytes& raw);

// Hands over what unpack_zstd() returns. Errors: as there, cannot-read, those of the sink.
Result<void> visit_unpacked_zstd(const StoredBytes& stored, std::uint64_t raw_size,
                                 const ByteSink& sink);

}  // namespace sightline
