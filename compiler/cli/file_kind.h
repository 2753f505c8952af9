#pragma once

#include <filesystem>
#include <optional>

#include "formats/base/error.h"

namespace sightline {

// What a path leads to, by its first bytes or its ending.
enum class FileKind { kFolder, kMap, kModel, kPoses, kDelta, kConfiguration, kRecording };

// Whether the ending is that of a recording of many scans: a bag or a capture.
bool holds_many_scans(const std::filesystem::path& path);

// Nothing: none of these, or it cannot be read.
std::optional<FileKind> kind_of_file(const std::filesystem::path& path);

// The same error; where its file was not understood because it is of another kind than was wanted,
// its message names the kind of the file and the verb that takes it, and replaces the message of
// the reader of the wrong kind. Where there is no such file, it adds why: the nearest name in its
// folder, a backslash, a pattern, ~ or $.
Error explain_wrong_file(Error error);

}  // namespace sightline
