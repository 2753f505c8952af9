#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "formats/base/result.h"

// Files that strangers name are opened here and nowhere else: what is no regular file is refused
// at once. A pipe would wait for a writer, a device may never end.

namespace sightline {

// Owns a file descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();

  [[nodiscard]] int number() const { return number_; }
  // Closes now; the error number, 0 where there is none. Some file systems tell only here that
  // what was written did not fit.
  int close();

 private:
  int number_ = -1;
};

struct RegularFile {
  Descriptor descriptor;
  std::uint64_t size = 0;  // when it was opened
};

// Opens for reading. Errors: file-not-found, cannot-open, cannot-read (a pipe, device or folder).
Result<RegularFile> open_regular_file(const std::string& path);

// The first bytes of a file, fewer where it has no more. Errors: as above.
Result<std::string> read_beginning(const std::string& path, std::size_t most_bytes);

}  // namespace sightline
