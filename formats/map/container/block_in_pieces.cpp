// zstd packs the same bytes in another way where it does not see them in one stretch of memory. So
// it does: they are read into a reserved stretch of their size just before they are packed, and
// their pages are given back when they lie behind its window.
#define ZSTD_STATIC_LINKING_ONLY  // packing without buffers between
#include "formats/map/container/block_in_pieces.h"

#include <sys/mman.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/reader/map_layout.h"

// Deprecated, since few need it: only this way zstd packs bytes piece by piece where they lie.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace sightline {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;  // a multiple of zstd's blocks

// Addresses without memory, which comes where they are written to.
class Stretch {
 public:
  explicit Stretch(std::size_t size)
      : size_(size),
        begin_(::mmap(nullptr, size, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {}
  Stretch(const Stretch&) = delete;
  Stretch& operator=(const Stretch&) = delete;
  ~Stretch() {
    if (is_there()) ::munmap(begin_, size_);
  }

  [[nodiscard]] bool is_there() const { return begin_ != MAP_FAILED; }
  [[nodiscard]] std::span<std::byte> part(std::size_t offset, std::size_t size) const {
    return {static_cast<std::byte*>(begin_) + offset, size};
  }
  // What lies before `offset` is not read again.
  void give_back_before(std::size_t offset) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::size_t end = offset / page * page;
    if (end <= given_back_) return;
    ::madvise(static_cast<std::byte*>(begin_) + given_back_, end - given_back_, MADV_DONTNEED);
    given_back_ = end;
  }

 private:
  std::size_t size_;
  void* begin_;
  std::size_t given_back_ = 0;
};

Error out_of_memory() { return {ErrorCode::kOutOfMemory, "not enough memory to pack", "", ""}; }

struct PackerDeleter {
  void operator()(ZSTD_CCtx* packer) const { ZSTD_freeCCtx(packer); }
};
struct UnpackerDeleter {
  void operator()(ZSTD_DStream* unpacker) const { ZSTD_freeDStream(unpacker); }
};

// As ZSTD_compress. `raw` is not empty.
Result<StoredBytes> packed(const StoredBytes& raw) {
  const ZSTD_parameters parameters = ZSTD_getParams(kPackLevel, raw.size(), 0);
  const std::size_t window = std::size_t{1} << parameters.cParams.windowLog;
  const std::unique_ptr<ZSTD_CCtx, PackerDeleter> packer(ZSTD_createCCtx());
  Stretch stretch(raw.size());
  if (!stretch.is_there() ||
      ZSTD_isError(ZSTD_compressBegin_advanced(packer.get(), nullptr, 0, parameters, raw.size()))) {
    return out_of_memory();
  }
  std::vector<std::byte> room(ZSTD_compressBound(kPiece) + ZSTD_FRAMEHEADERSIZE_MAX);
  GrowingBytes bytes(kPiece);
  for (std::uint64_t at = 0; at < raw.size(); at += kPiece) {
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, raw.size() - at));
    const std::span<std::byte> piece = stretch.part(at, size);
    SIGHTLINE_TRY(raw.read(at, piece));
    const auto pack = at + size == raw.size() ? ZSTD_compressEnd : ZSTD_compressContinue;
    const std::size_t packed_size =
        pack(packer.get(), room.data(), room.size(), piece.data(), piece.size());
    if (ZSTD_isError(packed_size) != 0) return out_of_memory();
    SIGHTLINE_TRY(bytes.append(std::span(room).first(packed_size)));
    if (at > window) stretch.give_back_before(at - window);
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
  const auto beginning = std::min<std::uint64_t>(stored.size(), ZSTD_FRAMEHEADERSIZE_MAX);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> head, stored.read(0, beginning));
  SIGHTLINE_TRY(check_packed_size(head, stored.size(), raw_size));
  const std::unique_ptr<ZSTD_DStream, UnpackerDeleter> unpacker(ZSTD_createDStream());
  std::vector<std::byte> room(ZSTD_DStreamOutSize());
  std::size_t left = 1;  // of the frame; 0 at its end
  std::uint64_t found = 0;
  SIGHTLINE_TRY(stored.visit([&](std::span<const std::byte> piece) -> Result<void> {
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    bool is_full = true;  // then more may be waiting
    while (in.pos < in.size || is_full) {
      if (left == 0 && in.pos < in.size) return unreadable_block();  // bytes behind the frame
      ZSTD_outBuffer out{room.data(), room.size(), 0};
      left = ZSTD_decompressStream(unpacker.get(), &out, &in);
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

#pragma GCC diagnostic pop
