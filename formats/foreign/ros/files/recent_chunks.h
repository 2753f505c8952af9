#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

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
