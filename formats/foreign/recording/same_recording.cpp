#include "formats/foreign/recording/same_recording.h"

#include <algorithm>
#include <span>

#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/recording/scan_files.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

fs::path without_links(const std::string& path) {
  std::error_code failure;
  const fs::path found = fs::weakly_canonical(fs::absolute(path, failure), failure);
  if (failure) return path;
  return found.has_filename() ? found : found.parent_path();
}

// A recording of rosbag2 is a folder.
std::vector<fs::path> files_of_bag(const fs::path& path) {
  std::error_code failure;
  if (!fs::is_directory(path, failure)) return {path};
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(path, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    files.push_back(entry->path());
  }
  std::ranges::sort(files);
  return files;
}

std::vector<fs::path> files_with_scans(const fs::path& path) {
  if (is_scan_container(path)) return files_of_bag(path);
  Result<std::vector<fs::path>> files = list_scan_files(path);
  return files ? *std::move(files) : std::vector<fs::path>();
}

// Both files are of this size.
bool has_equal_bytes(const fs::path& a, const fs::path& b, std::uintmax_t size) {
  const Result<RandomAccessFile> first = RandomAccessFile::open(a);
  const Result<RandomAccessFile> second = RandomAccessFile::open(b);
  if (!first || !second) return false;
  constexpr std::size_t kMost = std::size_t{1} << 20U;
  std::vector<std::byte> bytes(kMost);
  std::vector<std::byte> other(kMost);
  for (std::uintmax_t at = 0; at < size; at += kMost) {
    const auto count = static_cast<std::size_t>(std::min<std::uintmax_t>(kMost, size - at));
    const std::span<std::byte> part = std::span(bytes).first(count);
    const std::span<std::byte> of_other = std::span(other).first(count);
    if (!first->read(at, part) || !second->read(at, of_other)) return false;
    if (!std::ranges::equal(part, of_other)) return false;
  }
  return true;
}

}  // namespace

std::string RecordingPlace::name() const { return path.string() + "\n" + topic; }

RecordingPlace place_of(const RecordingOptions& options) {
  RecordingPlace place{without_links(options.scans), options.topic, {}, {}};
  place.files = files_with_scans(place.path);
  for (const fs::path& file : place.files) {
    std::error_code failure;
    place.sizes.push_back(fs::file_size(file, failure));
  }
  return place;
}

bool is_same_recording(const RecordingPlace& a, const RecordingPlace& b) {
  const bool is_one_topic = a.topic == b.topic || a.topic.empty() || b.topic.empty();
  if (!is_one_topic) return false;
  if (a.path == b.path) return true;
  if (a.files.empty() || a.sizes != b.sizes) return false;
  for (std::size_t i = 0; i < a.files.size(); ++i) {
    if (!has_equal_bytes(a.files[i], b.files[i], a.sizes[i])) return false;
  }
  return true;
}

bool is_same_recording(const RecordingOptions& a, const RecordingOptions& b) {
  return is_same_recording(place_of(a), place_of(b));
}

Digest scans_digest(const Recording& recording) {
  DigestBuilder digest;
  for (const RecordedScan& scan : recording.scans) digest.add(scan.content);
  return digest.finish();
}

}  // namespace sightline
