#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

enum class IfExists { kRefuse, kReplace };

// Writes beside the target, fsyncs and renames, so that the file appears whole or not at all; what
// was written so far is removed on failure. Missing parent directories are made.
// Errors: output-exists, disk-full, cannot-write.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes, IfExists if_exists);
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   IfExists if_exists);

// Bytes in memory that nobody filled with zeros first.
class FileContent {
 public:
  FileContent() = default;
  explicit FileContent(std::size_t size) : bytes_(new std::byte[size]), size_(size) {}
  [[nodiscard]] std::byte* data() { return bytes_.get(); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0;
};

// The whole file. Errors: file-not-found, cannot-open, cannot-read.
Result<FileContent> read_file_content(const std::filesystem::path& path);
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path);
Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace sightline
