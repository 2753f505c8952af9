#include "formats/map/container/block_in_pieces.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "formats/base/zstd_memory.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

// The most bytes that a frame's header takes.
constexpr std::uint64_t kLongestHead = 18;

struct PackerDeleter {
  void operator()(ZSTD_CCtx* packer) const { ZSTD_freeCCtx(packer); }
};
struct UnpackerDeleter {
  void operator()(ZSTD_DStream* unpacker) const { ZSTD_freeDStream(unpacker); }
};

Error out_of_memory() { return {ErrorCode::kOutOfMemory, "not enough memory to pack"}; }

// What is so long is a model, whose trees repeat what lies far behind: a window of 8 MiB packs it
// 3 % smaller at a level that takes a seventh of the time and half the memory of kPackLevel.
constexpr int kLongBlockLevel = 10;
constexpr int kLongBlockWindowLog = 23;

void set_level(std::uint64_t raw_size, ZSTD_CCtx* packer) {
  if (raw_size <= kPackedPiece) {
    ZSTD_CCtx_setParameter(packer, ZSTD_c_compressionLevel, kPackLevel);
    return;
  }
  ZSTD_CCtx_setParameter(packer, ZSTD_c_compressionLevel, kLongBlockLevel);
  ZSTD_CCtx_setParameter(packer, ZSTD_c_windowLog, kLongBlockWindowLog);
}

// One frame. `raw` is not empty.
Result<StoredBytes> packed(const StoredBytes& raw) {
  const std::unique_ptr<ZSTD_CCtx, PackerDeleter> packer(with_memory(ZSTD_createCCtx()));
  set_level(raw.size(), packer.get());
  ZSTD_CCtx_setPledgedSrcSize(packer.get(), raw.size());
  // zstd packs the same bytes in another way where it is handed them in other pieces.
  std::vector<std::byte> piece(std::min<std::uint64_t>(kPackedPiece, raw.size()));
  std::vector<std::byte> room(ZSTD_compressBound(piece.size()));
  GrowingBytes bytes(room.size());
  for (std::uint64_t at = 0; at < raw.size(); at += piece.size()) {
    piece.resize(std::min<std::uint64_t>(piece.size(), raw.size() - at));
    SIGHTLINE_TRY(raw.read(at, piece));
    const bool is_last = at + piece.size() == raw.size();
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    for (std::size_t left = 1; is_last ? left != 0 : in.pos < in.size;) {
      ZSTD_outBuffer out{room.data(), room.size(), 0};
      left = ZSTD_compressStream2(packer.get(), &out, &in, is_last ? ZSTD_e_end : ZSTD_e_continue);
      if (ZSTD_isError(left) != 0) return out_of_memory();
      SIGHTLINE_TRY(bytes.append(std::span(room).first(out.pos)));
    }
  }
  return bytes.take();
}

}  // namespace

Result<BlockInPieces> pack_in_pieces(const StoredBytes& raw) {
  if (raw.size() == 0) return BlockInPieces{};
  SIGHTLINE_ASSIGN(StoredBytes bytes, packed(raw));
  if (!is_worth_packing(raw.size(), bytes.size())) return BlockInPieces{BlockCodec::kNone, raw};
  return BlockInPieces{BlockCodec::kZstd, std::move(bytes)};
}

Result<void> visit_unpacked_zstd(const StoredBytes& stored, std::uint64_t raw_size,
                                 const ByteSink& sink) {
  const auto beginning = std::min<std::uint64_t>(stored.size(), kLongestHead);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> head, stored.read(0, beginning));
  SIGHTLINE_TRY(check_packed_size(head, stored.size(), raw_size));
  const std::unique_ptr<ZSTD_DStream, UnpackerDeleter> unpacker(with_memory(ZSTD_createDStream()));
  std::vector<std::byte> room(ZSTD_DStreamOutSize());
  std::size_t left = 1;  // of the frame; 0 at its end
  std::uint64_t found = 0;
  SIGHTLINE_TRY(stored.visit([&](std::span<const std::byte> piece) -> Result<void> {
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    bool is_full = true;  // then more may be waiting
    while (in.pos < in.size || is_full) {
      if (left == 0 && in.pos < in.size) return unreadable_block();  // bytes behind the frame
      ZSTD_outBuffer out{room.data(), room.size(), 0};
      left = with_memory(ZSTD_decompressStream(unpacker.get(), &out, &in));
      found += out.pos;
      if (ZSTD_isError(left) != 0 || found > raw_size) return unreadable_block();
      SIGHTLINE_TRY(sink(std::span(room).first(out.pos)));
      is_full = left != 0 && out.pos == out.size;
    }
    return {};
  }));
  if (left != 0 || found != raw_size) return unreadable_block();
  return {};
}

}  // namespace sightline
