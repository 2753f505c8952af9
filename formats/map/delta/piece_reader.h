#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"

namespace sightline {

// A regular file that is read piece by piece; not mapped, so that memory does not grow with it.
class PieceReader {
 public:
  // Errors: file-not-found, cannot-open, cannot-read (a folder, a pipe, a device).
  static Result<PieceReader> open(const std::filesystem::path& path);

  [[nodiscard]] std::uint64_t size() const { return file_.size; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  // Errors: cannot-read; truncated-file where the file has become shorter.
  [[nodiscard]] Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t size) const;

 private:
  PieceReader(std::filesystem::path path, RegularFile file)
      : path_(std::move(path)), file_(std::move(file)) {}
  std::filesystem::path path_;
  RegularFile file_;
};

}  // namespace sightline
