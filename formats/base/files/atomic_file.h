#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"

namespace sightline {

enum class IfExists { kRefuse, kReplace };
enum class FileAccess { kAll, kOwner };  // readable by all, or by its owner alone

// Writes beside the target under a temporary_name(), fsyncs and renames, so that the file appears
// whole or not at all; what was written so far is removed on failure, what killed runs left in the
// folder too. Missing parent directories are made. Only a regular file is ever replaced.
// Errors: those of check_output; disk-full, cannot-write.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes, IfExists if_exists,
                                   FileAccess access = FileAccess::kAll);
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   IfExists if_exists, FileAccess access = FileAccess::kAll);

// The same of bytes that `write` hands over piece by piece. Errors: those of `write` too.
using WriteInto = std::function<Result<void>(const ByteSink& file)>;
Result<void> write_file_atomically(const std::filesystem::path& path, const WriteInto& write,
                                   IfExists if_exists, FileAccess access = FileAccess::kAll);

// Whether the file may be written, for verbs that work for hours before they do.
// Errors: output-exists; cannot-write (a link, folder, pipe or device is there).
Result<void> check_output(const std::filesystem::path& path, IfExists if_exists);

// disk-full or cannot-write, from an errno.
Error write_failure(const std::filesystem::path& path, const std::string& what, int number);

// Writes all from the file's place on; the errno, 0 where there is none.
int write_all(const Descriptor& file, std::span<const std::byte> bytes);

// Bytes in memory that are not filled with zeros first.
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

// The whole file. Errors: those of open_regular_file; out-of-memory.
Result<FileContent> read_file_content(const std::filesystem::path& path);
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path);
Result<std::string> read_text_file(const std::filesystem::path& path);
// A file that is never longer. Errors: those of open_regular_file; too-large.
Result<std::string> read_short_text(const std::filesystem::path& path, std::size_t most_bytes);

}  // namespace sightline
