#pragma once

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/files/stored_bytes.h"

namespace sightline {

// A file in memory, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::byte> bytes)
      : descriptor_(::memfd_create("test", MFD_CLOEXEC)) {
    SIGHTLINE_CHECK(descriptor_ >= 0);
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), 0);
    SIGHTLINE_CHECK(written == static_cast<ssize_t>(bytes.size()));
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

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

// While it lives no file grows beyond a kilobyte, as on a full disk.
class NoLargeFiles {
 public:
  NoLargeFiles() {
    SIGHTLINE_CHECK(::getrlimit(RLIMIT_FSIZE, &before_) == 0);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    rlimit small = before_;
    small.rlim_cur = 1000;
    SIGHTLINE_CHECK(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  }
  NoLargeFiles(const NoLargeFiles&) = delete;
  NoLargeFiles& operator=(const NoLargeFiles&) = delete;
  ~NoLargeFiles() {
    (void)::setrlimit(RLIMIT_FSIZE, &before_);
    (void)std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

}  // namespace sightline
