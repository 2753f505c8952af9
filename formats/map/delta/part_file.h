#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// A file that is made from its beginning to its end, perhaps in several goes: what an earlier go
// left is compared and kept as long as it is right; from the first wrong byte on it is written
// anew.
class PartFile {
 public:
  // Makes the file where there is none. One process at a time: it holds a lock until it is closed,
  // whatever the file is called by then, so keep it until it has been renamed into place. On a file
  // system without locks it takes a new file, and keeps nothing of an earlier go.
  // Errors: cannot-open (no regular file, a link, locked), cannot-write.
  static Result<PartFile> open(const std::filesystem::path& path);

  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();  // the file stays, unless it is empty

  // The next bytes. Errors: cannot-read, cannot-write, disk-full.
  Result<void> put(std::span<const std::byte> bytes);

  // The file ends here and is on the disk. Errors: cannot-write, disk-full.
  Result<void> finish();

  // What was written is of no use: the file is removed when it is closed.
  void discard();

  // Bytes that were there already.
  [[nodiscard]] std::uint64_t kept() const { return kept_; }

 private:
  PartFile(std::filesystem::path path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}
  static Result<PartFile> open_anew(const std::filesystem::path& path, int number);
  [[nodiscard]] Result<bool> is_there(std::span<const std::byte> bytes);

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool is_own_ = false;  // no other process writes it
  std::uint64_t offset_ = 0;
  std::uint64_t kept_ = 0;
  bool is_comparing_ = true;
  std::vector<std::byte> found_;
};

}  // namespace sightline
