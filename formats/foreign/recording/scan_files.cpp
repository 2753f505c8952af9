#include "formats/foreign/recording/scan_files.h"

#include <algorithm>
#include <array>

#include "formats/base/files/regular_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/logs/open_capture.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

// Other point clouds: named, so that a folder of them is not called empty.
constexpr std::array<std::string_view, 13> kForeign = {".laz", ".e57",  ".pcap", ".pcapng", ".bag",
                                                       ".db3", ".mcap", ".npz",  ".xyz",    ".vtk",
                                                       ".osf", ".lvx",  ".lvx2"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// The run of digits at the front, cut off from `text`, without leading zeros.
std::string_view take_digits(std::string_view& text) {
  const auto* end = std::ranges::find_if_not(text, is_digit);
  std::string_view digits = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(digits.size());
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

// Below, equal or above as numbers of any length.
int compare_digits(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  return a.compare(b);
}

struct Candidates {
  std::vector<std::filesystem::path> files;
  std::vector<std::filesystem::path> folders;
};

// A link to nothing, a pipe or a socket is no scan, whatever its name.
Result<void> check_is_file(const std::filesystem::path& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (std::filesystem::is_regular_file(status)) return {};
  std::error_code ignored;
  if (std::filesystem::is_symlink(path, ignored) && !std::filesystem::exists(status)) {
    return Error{ErrorCode::kFileNotFound,
                 concat("a link to ", std::filesystem::read_symlink(path, ignored).string(),
                        ", which does not exist. Remove the link or restore the scan"),
                 path.string()};
  }
  return Error{ErrorCode::kCannotRead,
               failure ? "cannot read its properties: " + failure.message() : "not a regular file",
               path.string()};
}

Result<Candidates> list_candidates(const std::filesystem::path& folder) {
  std::error_code failure;
  if (!std::filesystem::exists(folder, failure)) {
    return Error{ErrorCode::kFileNotFound, "the folder does not exist", folder.string()};
  }
  if (std::filesystem::is_other(folder, failure)) {
    return Error{ErrorCode::kCannotRead, "neither a folder nor a regular file", folder.string()};
  }
  std::filesystem::directory_iterator entry(folder, failure);
  Candidates candidates;
  while (!failure && entry != std::filesystem::directory_iterator()) {
    const std::filesystem::path path = entry->path();
    const bool is_hidden = path.filename().string().starts_with('.');
    const std::string extension = lower_extension(path);
    std::error_code ignored;
    if (entry->is_directory(ignored)) {
      candidates.folders.push_back(path);
    } else if (!is_hidden && (is_scan_ending(extension) ||
                              std::ranges::find(kForeign, extension) != kForeign.end())) {
      candidates.files.push_back(path);
    }
    entry.increment(failure);
  }
  if (failure) {
    return Error{ErrorCode::kCannotOpen, "cannot list the folder: " + failure.message(),
                 folder.string()};
  }
  std::ranges::sort(candidates.files, [](const auto& a, const auto& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  std::ranges::sort(candidates.folders);
  return candidates;
}

// The scans are often one folder deeper than people think.
std::string hint_of_folders(const std::vector<std::filesystem::path>& folders) {
  for (const std::filesystem::path& folder : folders) {
    const Result<Candidates> inner = list_candidates(folder);
    if (inner && !inner->files.empty()) {
      return concat("; its folder ", folder.filename().string(), " does");
    }
  }
  return "";
}

// A file where a folder of scans or a recording of many was wanted, of a format that must be
// converted: its message says how.
Result<void> check_is_no_foreign_file(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  const Result<PointCloudFile> scan = read_point_cloud(file);
  const bool is_foreign = !scan && scan.error().code == ErrorCode::kUnsupportedFormat;
  return is_foreign ? Result<void>(scan.error()) : Result<void>();
}

// A file's first bytes; shorter where there are no more.
std::string signature_of(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_beginning(path.string(), 4);
  return bytes ? *bytes : std::string();
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
  std::string_view rest_a = a;
  std::string_view rest_b = b;
  while (!rest_a.empty() && !rest_b.empty()) {
    if (is_digit(rest_a.front()) && is_digit(rest_b.front())) {
      const int order = compare_digits(take_digits(rest_a), take_digits(rest_b));
      if (order != 0) return order < 0;
      continue;
    }
    if (rest_a.front() != rest_b.front()) return rest_a.front() < rest_b.front();
    rest_a.remove_prefix(1);
    rest_b.remove_prefix(1);
  }
  if (rest_a.empty() != rest_b.empty()) return rest_a.empty();
  return a < b;
}

Result<std::vector<std::filesystem::path>> list_scan_files(const std::filesystem::path& folder) {
  SIGHTLINE_TRY(check_is_no_foreign_file(folder));
  SIGHTLINE_ASSIGN(const Candidates candidates, list_candidates(folder));
  const std::vector<std::filesystem::path>& files = candidates.files;
  if (files.empty()) {
    return Error{ErrorCode::kEmptyDirectory,
                 concat("the folder contains no scans (", scan_endings_text(), ")",
                        hint_of_folders(candidates.folders)),
                 folder.string()};
  }
  for (const std::filesystem::path& file : files) SIGHTLINE_TRY(check_is_file(file));
  const std::string extension = lower_extension(files.front());
  const bool are_none_read = std::ranges::none_of(
      files, [](const auto& file) { return is_scan_ending(lower_extension(file)); });
  if (are_none_read) SIGHTLINE_TRY(read_point_cloud(files.front()));  // says what to do with it
  for (const std::filesystem::path& file : files) {
    if (lower_extension(file) != extension) {
      return Error{ErrorCode::kMixedFormats,
                   concat("scans of several formats, such as ", files.front().filename().string(),
                          " and ", file.filename().string(), "; expected one"),
                   folder.string()};
    }
  }
  return files;
}

std::optional<std::int64_t> scan_number(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  std::size_t end = stem.size();
  while (end > 0 && !is_digit(stem[end - 1])) --end;
  std::size_t first = end;
  while (first > 0 && is_digit(stem[first - 1])) --first;
  return to_number<std::int64_t>(std::string_view(stem).substr(first, end - first));
}

std::optional<std::int64_t> scan_stamp_ns(const std::filesystem::path& file) {
  constexpr std::size_t kLeastDigits = 15;  // of a whole number
  std::string stem = file.stem().string();
  // nuScenes: "n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927647951.pcd.bin".
  const std::size_t lidar = stem.rfind("__LIDAR_");
  if (lidar != std::string::npos) {
    stem = stem.substr(stem.rfind("__") + 2);
    stem = stem.substr(0, stem.find('.'));
  }
  const bool is_plain = std::ranges::all_of(stem, [](char c) { return is_digit(c) || c == '.'; });
  const bool has_point = stem.find('.') != std::string::npos;
  const std::size_t zeros = std::min(stem.find_first_not_of('0'), stem.size());
  if (!is_plain || (!has_point && stem.size() - zeros < kLeastDigits)) return std::nullopt;
  return parse_stamp_ns(stem);
}

bool is_scan_container(const std::filesystem::path& path) {
  if (is_ros_bag(path)) return true;
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored) && is_pcap(signature_of(path));
}

Result<std::shared_ptr<const ScanContainer>> open_scan_container(
    const std::filesystem::path& path, const std::string& topic,
    const std::filesystem::path& sensor) {
  if (is_ros_bag(path)) return open_bag(path, topic);
  if (topic.empty()) return open_capture(path, sensor);
  return Error{ErrorCode::kBadValue, concat("a pcap has no topics, found topic '", topic, "'"),
               path.string()};
}

}  // namespace sightline
