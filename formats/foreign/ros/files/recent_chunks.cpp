#include "formats/foreign/ros/files/recent_chunks.h"

#include <algorithm>
#include <span>

#include "formats/base/check.h"

namespace sightline {

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
