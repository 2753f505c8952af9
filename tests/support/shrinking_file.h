#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/files/stored_bytes.h"

namespace sightline {

// Bytes in a temporary file that another program cuts short later.
class ShrinkingFile {
 public:
  explicit ShrinkingFile(const std::vector<std::byte>& bytes) : file_(std::tmpfile()) {
    SIGHTLINE_CHECK(file_ != nullptr);
    SIGHTLINE_CHECK(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
    SIGHTLINE_CHECK(std::fflush(file_) == 0);
    bytes_ = StoredBytes(Descriptor(::dup(::fileno(file_))), bytes.size());
  }
  ShrinkingFile(const ShrinkingFile&) = delete;
  ShrinkingFile& operator=(const ShrinkingFile&) = delete;
  ~ShrinkingFile() { std::fclose(file_); }

  [[nodiscard]] const StoredBytes& bytes() const { return bytes_; }
  void shrink() { SIGHTLINE_CHECK(::ftruncate(::fileno(file_), 10) == 0); }

 private:
  std::FILE* file_;
  StoredBytes bytes_;
};

}  // namespace sightline
