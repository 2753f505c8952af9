#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// How the chunks of a ROS 1 bag or of an MCAP file are packed.
enum class BagCompression { kNone, kBz2, kLz4, kZstd };

// "none", "bz2" or "lz4", as a chunk's header says it in ROS 1; nothing for any other.
std::optional<BagCompression> bag_compression_named(std::string_view name);
// "", "lz4" or "zstd", as MCAP says it.
std::optional<BagCompression> mcap_compression_named(std::string_view name);

// The most bytes that `packed_size` bytes may unpack to: 1 GiB, and 16 MiB plus 1024 for each byte,
// so that a small file never asks for much memory.
std::size_t most_unpacked(std::size_t packed_size);

// What a packed chunk (not kNone) holds; nothing where that is damaged or not `size` bytes, which
// must be at most most_unpacked().
std::optional<std::vector<std::byte>> unpack_chunk(BagCompression compression,
                                                   std::span<const std::byte> packed,
                                                   std::size_t size);

// What a frame of zstd holds, by the size that it says itself; nothing where it is damaged, says no
// size or one above most_unpacked().
std::optional<std::vector<std::byte>> unpack_zstd_frame(std::span<const std::byte> packed);
// Whether bytes begin like one.
bool is_zstd_frame(std::span<const std::byte> bytes);

// Bytes of a chunk of a recording, after it is unpacked.
struct ChunkPart {
  std::size_t chunk = 0;
  std::size_t chunk_size = 0;  // unpacked
  std::size_t offset = 0;
  std::size_t size = 0;
};

// The chunks that were read last, unpacked. Several scans lie in a chunk, and each thread reads
// scans of a part of the drive: with a chunk for each thread none is unpacked twice. Safe from
// several threads, which unpack different chunks at the same time.
class RecentChunks {
 public:
  static constexpr std::size_t kMost_bytes = std::size_t{64} << 20U;
  static constexpr std::size_t kMost_chunks = 64;

  // Keeps at most so many bytes, but at least one chunk. Besides, each thread holds the chunk that
  // it reads; those of more than an eighth of `most_bytes` are read by one thread at a time.
  explicit RecentChunks(std::size_t most_bytes = kMost_bytes) : most_bytes_(most_bytes) {}

  // unpack() returns all bytes of the chunk and is called where they are not kept. Its errors are
  // returned; the next read calls it again.
  using Unpack = std::function<Result<std::vector<std::byte>>()>;
  Result<std::vector<std::byte>> read(const ChunkPart& part, const Unpack& unpack);

 private:
  struct Chunk {
    std::size_t index = 0;
    std::size_t size = 0;
    std::mutex mutex;
    bool is_unpacked = false;
    std::vector<std::byte> bytes;
  };
  std::shared_ptr<Chunk> chunk_of(const ChunkPart& part);

  std::size_t most_bytes_;
  std::mutex large_;  // is read now
  std::mutex mutex_;
  std::size_t bytes_ = 0;                       // of chunks_
  std::vector<std::shared_ptr<Chunk>> chunks_;  // the one that was read last at the end
};

}  // namespace sightline
