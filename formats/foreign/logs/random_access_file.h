#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"

namespace sightline {

// A regular file that is read at any offset. Safe from several threads.
class RandomAccessFile {
 public:
  // Errors: as open_regular_file().
  static Result<RandomAccessFile> open(const std::filesystem::path& path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // When it was opened, bytes.
  [[nodiscard]] std::uint64_t size() const { return file_.size; }
  // Fills `bytes` from `offset` on. Error: cannot-read (the file has become shorter, too).
  Result<void> read(std::uint64_t offset, std::span<std::byte> bytes) const;
  // An error at a byte of the file; malformed-header where no code is given.
  [[nodiscard]] Error error_at(std::uint64_t offset, std::string message,
                               ErrorCode code = ErrorCode::kMalformedHeader) const {
    return {code, std::move(message), path_.string(), "byte " + std::to_string(offset)};
  }

 private:
  RandomAccessFile(std::filesystem::path path, RegularFile file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  RegularFile file_;
};

}  // namespace sightline
