#include "formats/foreign/ros/files/bag_chunks.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>

#include "formats/base/check.h"
#include "formats/base/zstd_memory.h"

namespace sightline {
namespace {

bool unpack_bz2(std::span<const std::byte> packed, std::span<std::byte> unpacked) {
  auto size = static_cast<unsigned>(unpacked.size());
  // libbz2 does not write where the packed bytes lie.
  auto* source = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
  const int status = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(unpacked.data()), &size,
                                                source, static_cast<unsigned>(packed.size()), 0, 0);
  if (status == BZ_MEM_ERROR) throw std::bad_alloc();
  return status == BZ_OK && size == unpacked.size();
}

// One frame of LZ4, which the checksums of the frame must bear out.
bool unpack_lz4(std::span<const std::byte> packed, std::span<std::byte> unpacked) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, &LZ4F_freeDecompressionContext);
  while (true) {
    std::size_t written = unpacked.size();
    std::size_t taken = packed.size();
    const std::size_t status =
        LZ4F_decompress(context.get(), unpacked.data(), &written, packed.data(), &taken, nullptr);
    if (LZ4F_isError(status) != 0) return false;
    unpacked = unpacked.subspan(written);
    packed = packed.subspan(taken);
    if (status == 0) return unpacked.empty();  // the end of the frame
    if (written == 0 && taken == 0) return false;
  }
}

bool unpack_zstd(std::span<const std::byte> packed, std::span<std::byte> unpacked) {
  return with_memory(ZSTD_decompress(unpacked.data(), unpacked.size(), packed.data(),
                                     packed.size())) == unpacked.size();
}

bool unpack(BagCompression compression, std::span<const std::byte> packed,
            std::span<std::byte> unpacked) {
  switch (compression) {
    case BagCompression::kBz2:
      return unpack_bz2(packed, unpacked);
    case BagCompression::kLz4:
      return unpack_lz4(packed, unpacked);
    default:
      return unpack_zstd(packed, unpacked);
  }
}

}  // namespace

std::optional<BagCompression> mcap_compression_named(std::string_view name) {
  if (name.empty()) return BagCompression::kNone;
  if (name == "lz4") return BagCompression::kLz4;
  if (name == "zstd") return BagCompression::kZstd;
  return std::nullopt;
}

std::optional<BagCompression> bag_compression_named(std::string_view name) {
  if (name == "none") return BagCompression::kNone;
  if (name == "bz2") return BagCompression::kBz2;
  if (name == "lz4") return BagCompression::kLz4;
  return std::nullopt;
}

std::size_t most_unpacked(std::size_t packed_size) {
  constexpr std::size_t kMost = std::size_t{1} << 30U;
  constexpr std::size_t kAlways = std::size_t{1} << 24U;  // 20 chunks of the recorder's own choice
  constexpr std::size_t kRatio = 1024;  // LZ4 reaches 255; scans that bz2 packs reach 10
  return packed_size >= kMost / kRatio ? kMost : std::min(kMost, kAlways + kRatio * packed_size);
}

std::optional<std::vector<std::byte>> unpack_chunk(BagCompression compression,
                                                   std::span<const std::byte> packed,
                                                   std::size_t size) {
  SIGHTLINE_CHECK(compression != BagCompression::kNone && size <= most_unpacked(packed.size()));
  std::vector<std::byte> unpacked(std::max<std::size_t>(size, 1));  // the libraries want an address
  const std::span<std::byte> place(unpacked.data(), size);
  if (!unpack(compression, packed, place)) return std::nullopt;
  unpacked.resize(size);
  return unpacked;
}

bool is_zstd_frame(std::span<const std::byte> bytes) {
  constexpr std::array<std::byte, 4> kMagic = {std::byte{0x28}, std::byte{0xb5}, std::byte{0x2f},
                                               std::byte{0xfd}};
  return bytes.size() > kMagic.size() && std::ranges::equal(bytes.first(kMagic.size()), kMagic);
}

std::optional<std::vector<std::byte>> unpack_zstd_frame(std::span<const std::byte> packed) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  if (size > most_unpacked(packed.size())) return std::nullopt;
  return unpack_chunk(BagCompression::kZstd, packed, static_cast<std::size_t>(size));
}

std::shared_ptr<RecentChunks::Chunk> RecentChunks::chunk_of(const ChunkPart& part) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(chunks_, part.chunk, [](const auto& c) { return c->index; });
  if (found != chunks_.end()) {
    std::rotate(found, found + 1, chunks_.end());
    return chunks_.back();
  }
  const std::shared_ptr<Chunk>& added = chunks_.emplace_back(std::make_shared<Chunk>());
  added->index = part.chunk;
  added->size = part.chunk_size;
  bytes_ += part.chunk_size;
  while (chunks_.size() > 1 && (bytes_ > most_bytes_ || chunks_.size() > kMost_chunks)) {
    bytes_ -= chunks_.front()->size;
    chunks_.erase(chunks_.begin());
  }
  return chunks_.back();
}

Result<std::vector<std::byte>> RecentChunks::read(const ChunkPart& part, const Unpack& unpack) {
  std::unique_lock<std::mutex> alone(large_, std::defer_lock);
  if (part.chunk_size > most_bytes_ / 8) alone.lock();
  const std::shared_ptr<Chunk> chunk = chunk_of(part);
  const std::scoped_lock lock(chunk->mutex);
  if (!chunk->is_unpacked) {
    SIGHTLINE_ASSIGN(chunk->bytes, unpack());
    chunk->is_unpacked = true;
  }
  const std::span<const std::byte> bytes = chunk->bytes;
  SIGHTLINE_CHECK(part.offset <= bytes.size() && part.size <= bytes.size() - part.offset);
  const std::span<const std::byte> wanted = bytes.subspan(part.offset, part.size);
  return std::vector<std::byte>(wanted.begin(), wanted.end());
}

}  // namespace sightline
