#pragma once

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/result.h"

namespace sightline {

// The chunk of a recording that was unpacked last: scans are read one after the other, and several
// lie in a chunk. Safe from several threads.
class LastChunk {
 public:
  // `size` bytes from `offset` on of a chunk; unpack() gives a Result of all its bytes.
  template <class Unpack>
  Result<std::vector<std::byte>> read(std::size_t chunk, std::size_t offset, std::size_t size,
                                      Unpack unpack) {
    const std::scoped_lock lock(mutex_);
    if (bytes_.empty() || chunk_ != chunk) {
      bytes_.clear();
      SIGHTLINE_ASSIGN(bytes_, unpack());
      chunk_ = chunk;
    }
    SIGHTLINE_CHECK(offset <= bytes_.size() && size <= bytes_.size() - offset);
    const std::span<const std::byte> part = std::span(bytes_).subspan(offset, size);
    return std::vector<std::byte>(part.begin(), part.end());
  }

 private:
  std::mutex mutex_;
  std::size_t chunk_ = 0;
  std::vector<std::byte> bytes_;  // empty: none was read
};

}  // namespace sightline
