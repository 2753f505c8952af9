#include "compiler/cli/file_kind.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include "formats/base/files/regular_file.h"
#include "formats/reader/map_layout.h"
#include "passes/pass/options.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The first bytes of deltas (schemas/delta_format.md) and of artifacts (formats/artifact.h).
constexpr std::string_view kDeltaBegins("\x89SLD\r\n\x1a\n", 8);
constexpr std::string_view kArtifactBegins("SLA\x1a", 4);

bool has_ending(const fs::path& path, std::initializer_list<std::string_view> endings) {
  return std::ranges::find(endings, path.extension().string()) != endings.end();
}

std::string folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path().string() : ".";
}

// What it is, and which verb takes it.
std::string description(FileKind kind, const std::string& path) {
  switch (kind) {
    case FileKind::kFolder:
      return concat(
          "a folder. `sightline init ", path,
          " -o drive.yaml` writes a configuration for the recordings in it, and `sightline "
          "compile drive.yaml -o drive.slmap` makes the map");
    case FileKind::kMap:
      return concat("a compiled map: `sightline inspect ", path,
                    "` shows it, `sightline evaluate CONFIG --map ", path, "` judges it");
    case FileKind::kModel:
      return concat("an error model: `sightline inspect ", path,
                    "` shows it, `sightline compile CONFIG --model ", path, "` uses it");
    case FileKind::kPoses:
      return concat("a file of released poses: `base: ", path,
                    "` in a configuration keeps them while drives are added");
    case FileKind::kDelta:
      return "a delta between two maps: `sightline delta apply` updates a map with it";
    case FileKind::kConfiguration:
      return concat("a configuration: `sightline compile ", path, " -o drive.slmap` makes its map");
    case FileKind::kRecording:
      if (holds_many_scans(path)) {
        return concat(
            "a recording: `sightline init ", path,
            " -o drive.yaml` writes a configuration for it, and `sightline compile drive.yaml -o "
            "drive.slmap` makes the map");
      }
      return concat("one scan of a recording: `sightline init ", folder_of(path),
                    " -o drive.yaml` writes a configuration for its folder");
  }
  return "";
}

// Whether a failure of this code may come of a file of this kind where another one was wanted.
bool may_be_mistaken(const Error& error, FileKind kind) {
  switch (error.code) {
    case ErrorCode::kCannotRead:
      return kind == FileKind::kFolder;
    case ErrorCode::kCannotOpen:  // of what lists a folder
      return kind != FileKind::kFolder && error.message.find("folder") != std::string::npos &&
             !(kind == FileKind::kRecording && holds_many_scans(error.file));
    case ErrorCode::kMalformedText:
      return kind != FileKind::kFolder && kind != FileKind::kConfiguration;
    case ErrorCode::kBadMagic:
      return error.place == "byte 0";
    default:
      return false;
  }
}

// The entry of a folder whose name is nearest, small and capital letters apart first.
std::string nearest_entry(const fs::path& folder, const std::string& name) {
  constexpr std::size_t kMost = 10'000;
  const auto lower = [](std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
  };
  std::vector<std::string> names;
  std::error_code failure;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, failure);
       !failure && entry != fs::directory_iterator() && names.size() < kMost;
       entry.increment(failure)) {
    names.push_back(entry->path().filename().string());
  }
  std::ranges::sort(names);  // a folder has no order
  const auto same = std::ranges::find(names, lower(name), lower);
  return same != names.end() ? *same : nearest_name(name, names);
}

// Why a path may lead nowhere.
std::string hint_of_missing(const fs::path& path) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(path, ignored)))
    return "";  // a broken link has its own message
  const std::string text = path.string();
  if (text == "-") return "; a configuration is a file, since its paths are relative to it";
  for (const char* scheme : {"http:/", "https:/", "ftp:/", "s3:/", "gs:/", "file:/"}) {
    if (text.find(scheme) == std::string::npos) continue;
    return "; URLs are not read: download the file first, and name its path";
  }
  if (text.find('\\') != std::string::npos) return "; separate folders by /, not by a backslash";
  if (text.starts_with('~') || text.find("/~") != std::string::npos ||
      text.find('$') != std::string::npos) {
    return "; ~ and $ are not expanded here: write the whole path";
  }
  if (text.find_first_of("*?") != std::string::npos) {
    return "; patterns are not expanded here: name the folder";
  }
  const std::string near = nearest_entry(path.parent_path(), path.filename().string());
  return near.empty() ? "" : concat("; did you mean ", (path.parent_path() / near).string(), "?");
}

// What a checkout holds in the place of a file that Git LFS keeps elsewhere.
bool is_lfs_pointer(const Error& error) {
  const ErrorClass kind = error_class(error.code);
  if (kind != ErrorClass::kCorrupt && kind != ErrorClass::kInput) return false;
  constexpr std::string_view kBeginning = "version https://git-lfs";
  const Result<std::string> beginning = read_beginning(error.file, kBeginning.size());
  return beginning && *beginning == kBeginning;
}

}  // namespace

bool holds_many_scans(const fs::path& path) {
  return has_ending(path, {".bag", ".db3", ".mcap", ".pcap", ".pcapng"});
}

std::optional<FileKind> kind_of_file(const fs::path& path) {
  std::error_code failure;
  if (fs::is_directory(path, failure)) return FileKind::kFolder;
  if (!fs::is_regular_file(path, failure)) return std::nullopt;
  constexpr std::size_t kEnough = 512;
  const Result<std::string> beginning = read_beginning(path.string(), kEnough);
  const std::string bytes = beginning ? *beginning : std::string();
  if (bytes.starts_with(kMapBeginning)) return FileKind::kMap;
  if (bytes.starts_with(kDeltaBegins)) return FileKind::kDelta;
  if (bytes.starts_with(kArtifactBegins)) {
    if (bytes.find("error-model") != std::string::npos) return FileKind::kModel;
    if (bytes.find("released-poses") != std::string::npos) return FileKind::kPoses;
    return std::nullopt;
  }
  if (holds_many_scans(path) || has_ending(path, {".pcd", ".ply", ".las", ".bin", ".npy", ".gz"})) {
    return FileKind::kRecording;
  }
  const bool is_text = !bytes.empty() && bytes.find('\0') == std::string::npos;
  if (is_text && has_ending(path, {".yaml", ".yml"})) return FileKind::kConfiguration;
  return std::nullopt;
}

Error explain_wrong_file(Error error) {
  if (error.file.empty()) return error;
  if (error.code == ErrorCode::kFileNotFound) {
    error.message += hint_of_missing(error.file);
    return error;
  }
  if (error.code != ErrorCode::kGitLfsPointer && is_lfs_pointer(error)) {
    return {ErrorCode::kGitLfsPointer,
            "the file is a Git LFS pointer, not the data; run `git lfs pull` in its checkout",
            error.file};
  }
  const std::optional<FileKind> kind = kind_of_file(error.file);
  if (!kind || !may_be_mistaken(error, *kind)) return error;
  error.place.clear();
  error.message = "this is " + description(*kind, error.file);
  return error;
}

}  // namespace sightline
