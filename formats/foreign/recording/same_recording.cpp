#include "formats/foreign/recording/same_recording.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <string>

#include "formats/base/bytes.h"
#include "formats/base/units.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/record/codec.h"

namespace sightline {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::int64_t kSettled_ns = 2 * kSecond_ns;

std::int64_t nanoseconds(const timespec& time) {
  return std::int64_t{time.tv_sec} * kSecond_ns + time.tv_nsec;
}

std::int64_t now_ns() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

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

std::optional<Digest> state_of_files(const Recording& recording) {
  ByteWriter writer;
  writer.put(kVersion);
  writer.put_string(recording.columns ? to_text(*recording.columns) : "");
  const std::int64_t settled_ns = now_ns() - kSettled_ns;
  for (const RecordedScan& scan : recording.scans) {
    struct stat status {};
    const std::filesystem::path file = recording.file_of(scan);
    if (::stat(file.c_str(), &status) != 0) return std::nullopt;
    const std::int64_t written_ns = nanoseconds(status.st_mtim);
    const std::int64_t changed_ns = nanoseconds(status.st_ctim);
    if (std::max(written_ns, changed_ns) > settled_ns) return std::nullopt;
    writer.put_string(file.string());
    writer.put<std::uint64_t>(status.st_dev);
    writer.put<std::uint64_t>(status.st_ino);
    writer.put<std::int64_t>(status.st_size);
    writer.put(written_ns);
    writer.put(changed_ns);
  }
  return sha256(writer.bytes());
}

bool recall_digests(const DigestMemory& memory, const Digest& state, Recording& recording) {
  const std::optional<std::vector<std::byte>> found = memory.load(state);
  if (!found) return false;
  ByteReader reader(*found);
  FieldReader stored(reader);
  std::vector<Digest> contents;
  std::vector<std::uint64_t> contents_xxh3;
  std::string columns;
  std::vector<std::string> warnings;
  stored.get(contents);
  stored.get(contents_xxh3);
  stored.get(columns);
  stored.get(warnings);
  const std::size_t count = recording.scans.size();
  if (!reader.at_end() || contents.size() != count || contents_xxh3.size() != count) return false;
  if (!columns.empty()) {
    Result<FloatColumns> parsed = parse_float_columns(columns);
    if (!parsed) return false;
    recording.columns = *std::move(parsed);
  }
  for (std::size_t i = 0; i < count; ++i) {
    recording.scans[i].content = contents[i];
    recording.scans[i].content_xxh3 = contents_xxh3[i];
  }
  recording.warnings.insert(recording.warnings.end(), warnings.begin(), warnings.end());
  return true;
}

void remember_digests(const DigestMemory& memory, const Digest& state, const Recording& recording,
                      std::size_t first_warning) {
  std::vector<Digest> contents;
  std::vector<std::uint64_t> contents_xxh3;
  for (const RecordedScan& scan : recording.scans) {
    contents.push_back(scan.content);
    contents_xxh3.push_back(scan.content_xxh3);
  }
  const std::string columns = recording.columns ? to_text(*recording.columns) : "";
  const std::vector<std::string> warnings(
      recording.warnings.begin() + static_cast<std::ptrdiff_t>(first_warning),
      recording.warnings.end());
  memory.store(state, written(contents, contents_xxh3, columns, warnings).bytes());
}

std::string RecordingPlace::name() const { return concat(path.string(), "\n", topic); }

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
