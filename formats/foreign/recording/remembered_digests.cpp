#include "formats/foreign/recording/remembered_digests.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "formats/base/bytes.h"
#include "formats/base/units.h"
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

}  // namespace sightline
