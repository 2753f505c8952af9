#pragma once

#include <cstdint>

#include "formats/base/byte_sink.h"
#include "formats/base/result.h"
#include "formats/base/stored_bytes.h"
#include "formats/map/container/block_codec.h"

// Blocks that memory should not hold whole.

namespace sightline {

struct BlockInPieces {
  BlockCodec codec = BlockCodec::kNone;
  StoredBytes bytes;
};

// What pack() of all these bytes returns, bit for bit. Of the raw bytes only those are in memory
// that zstd may still refer to, some mebibytes. Errors: cannot-read, disk-full, cannot-write
// (temporary files), out-of-memory.
Result<BlockInPieces> pack_in_pieces(const StoredBytes& raw);

// Hands over what unpack_zstd() returns. Errors: as there, cannot-read, those of the sink.
Result<void> visit_unpacked_zstd(const StoredBytes& stored, std::uint64_t raw_size,
                                 const ByteSink& sink);

}  // namespace sightline
