#include "compiler/config/recordings.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "compiler/init/find_scans.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct NamedRecording {
  std::string name;
  fs::path scans;
  fs::path poses;  // empty: as in the section
};

Result<std::vector<NamedRecording>> in_folder(const fs::path& folder) {
  SIGHTLINE_ASSIGN(const ScanSearch search, find_scans(folder));
  const fs::path absolute = fs::current_path() / folder;
  std::vector<NamedRecording> named;
  for (const FoundScans& found : search.found) {
    const fs::path inner = found.scans.lexically_relative(absolute.lexically_normal());
    const bool is_itself = inner == ".";
    named.push_back({is_itself ? found.scans.filename().string() : inner.string(),
                     is_itself ? folder : folder / inner,
                     {}});
  }
  if (!named.empty()) return named;
  std::string message = "found no recording in this folder";
  for (const PassedOver& passed : search.passed_over) {
    message += concat("; ", passed.path.string(), ": ", passed.reason);
  }
  return Error{ErrorCode::kEmptyDirectory, message, folder.string()};
}

Result<std::vector<NamedRecording>> in_list(const fs::path& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(file));
  std::vector<NamedRecording> named;
  LineReader lines(text);
  std::vector<std::string_view> paths;
  for (std::string_view line; lines.next(line);) {
    split_words(line, paths, "\t");
    if (paths.empty() || paths[0].starts_with('#')) continue;
    if (paths.size() > 2) {
      return Error{ErrorCode::kMalformedText,
                   concat("found ", paths.size(),
                          " paths, expected the path of the scans and optionally, after a tab, the "
                          "path of the poses"),
                   file.string(), concat("line ", lines.number())};
    }
    const auto from_file = [&](std::string_view path) {
      return (file.parent_path() / fs::path(path)).lexically_normal();
    };
    named.push_back({std::string(paths[0]), from_file(paths[0]),
                     paths.size() == 2 ? from_file(paths[1]) : fs::path()});
  }
  if (!named.empty()) return named;
  return Error{ErrorCode::kMalformedText, "the list is empty, expected one path per line",
               file.string()};
}

// A file that lies with the scans, or beside their folder.
Result<std::string> companion_of(const fs::path& scans, const std::string& file) {
  std::error_code ignored;
  for (const fs::path& folder : {scans, scans.parent_path()}) {
    const fs::path candidate = folder / file;
    if (fs::exists(candidate, ignored)) return candidate.string();
  }
  return Error{ErrorCode::kFileNotFound,
               concat("found no file '", file, "' in or beside this folder of scans"),
               scans.string()};
}

Result<RecordingOptions> drive_of(const RecordingOptions& shared, const NamedRecording& named) {
  RecordingOptions drive = shared;
  drive.name = named.name;
  drive.scans = named.scans.string();
  if (!named.poses.empty()) {
    drive.poses = named.poses.string();
  } else if (!drive.poses.empty()) {
    SIGHTLINE_ASSIGN(drive.poses, companion_of(named.scans, shared.poses));
  }
  if (!drive.stamps.empty()) {
    SIGHTLINE_ASSIGN(drive.stamps, companion_of(named.scans, shared.stamps));
  }
  return drive;
}

Result<std::vector<RecordingOptions>> drives_of(const fs::path& recordings,
                                                const RecordingOptions& shared) {
  std::error_code ignored;
  SIGHTLINE_ASSIGN(const std::vector<NamedRecording> named, fs::is_directory(recordings, ignored)
                                                                ? in_folder(recordings)
                                                                : in_list(recordings));
  std::vector<RecordingOptions> drives;
  for (const NamedRecording& one : named) {
    SIGHTLINE_ASSIGN(RecordingOptions drive, drive_of(shared, one));
    drives.push_back(std::move(drive));
  }
  return drives;
}

}  // namespace

Result<void> expand_recordings(const std::string& section, const std::string& recordings,
                               RecordingOptions& first, std::deque<RecordingOptions>& more) {
  if (recordings.empty()) return {};
  const std::string key = section + ".recordings: ";
  if (!first.scans.empty() || !first.name.empty() || !more.empty()) {
    return Error{ErrorCode::kBadValue,
                 concat(key, "found ", (more.empty() ? "scans or a name" : "a list of drives"),
                        " beside it; use one or the other")};
  }
  Result<std::vector<RecordingOptions>> drives = drives_of(recordings, first);
  if (!drives) {
    Error error = drives.error();
    error.message = key + error.message;
    return error;
  }
  first = std::move(drives->front());
  for (std::size_t i = 1; i < drives->size(); ++i) more.push_back(std::move((*drives)[i]));
  return {};
}

}  // namespace sightline
