#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/base/result.h"

namespace sightline {

enum class IfExists { kRefuse, kReplace };

// Writes beside the target, fsyncs and renames, so that the file appears whole or not at all; what
// was written so far is removed on failure. Missing parent directories are made.
// Errors: output-exists, disk-full, cannot-write.
Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes, IfExists if_exists);
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   IfExists if_exists);

// The whole file. Errors: file-not-found, cannot-read.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path);
Result<std::string> read_text_file(const std::filesystem::path& path);

}  // namespace sightline
