#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "formats/base/result.h"

namespace sightline {

// A whole file as read-only memory (mmap, MAP_PRIVATE): pages are read when they are touched,
// unless the file is copied.
class MappedFile {
 public:
  // kHereAndThere reads no page that is not touched. kCopied reads all at once, into memory that no
  // other program changes.
  enum class Use { kThroughout, kHereAndThere, kCopied };
  // Anything but a regular file is refused at once, also a pipe without a writer.
  // Errors: file-not-found, cannot-open, cannot-read, out-of-memory.
  static Result<MappedFile> open(const std::string& path, Use use = Use::kThroughout);
  MappedFile() = default;  // no bytes

  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MappedFile();

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

}  // namespace sightline
