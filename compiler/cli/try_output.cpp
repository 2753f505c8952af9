#include "compiler/cli/try_output.h"

#include <unistd.h>

#include <cerrno>

#include "compiler/cli/file_kind.h"

namespace sightline {
namespace {

// What a slip of the pen would lose for good.
bool is_made_by_hand(const std::filesystem::path& path) {
  const std::optional<FileKind> kind = kind_of_file(path);
  return kind == FileKind::kConfiguration ||
         (kind == FileKind::kRecording && holds_many_scans(path));
}

}  // namespace

Result<void> try_output(const std::filesystem::path& path, IfExists if_exists) {
  if (path.empty()) return {};
  SIGHTLINE_TRY(check_output(path, if_exists));
  if (is_made_by_hand(path)) {
    return Error{ErrorCode::kCannotWrite,
                 "a configuration or a recording stands there, which no output replaces, --force "
                 "or not; name another file",
                 path.string()};
  }
  std::error_code failure;
  std::filesystem::path folder = std::filesystem::absolute(path, failure).parent_path();
  while (folder.has_relative_path() && !std::filesystem::exists(folder, failure)) {
    folder = folder.parent_path();
  }
  if (!std::filesystem::is_directory(folder, failure)) {
    return write_failure(path, folder.string() + " is in the way", ENOTDIR);
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return write_failure(path, "no file can be made in " + folder.string(), errno);
  }
  return {};
}

}  // namespace sightline
