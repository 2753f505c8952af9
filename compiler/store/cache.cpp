#include "compiler/store/cache.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "formats/base/bytes.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/files/temporary_name.h"

namespace sightline {
namespace {

constexpr std::string_view kPart = " part";
constexpr std::string_view kPartList = " part list";
constexpr std::string_view kWarnings = " warnings";
constexpr const char* kPartFolder = ".parts";
constexpr std::size_t kLargestRecord = 1 << 20;  // bytes; a pass has some dozens of options

// A pass may be named "ingest:localization", a file had better not.
std::string file_stem(std::string pass) {
  std::ranges::replace(pass, ':', '.');
  return pass;
}

// Steps of one pass share what they make: "ingest:mapping" and "ingest:localization" are "ingest".
std::string without_label(const std::string& pass) { return pass.substr(0, pass.find(':')); }

// 128 bits of the key: names stay readable and no two keys ever meet.
std::string stem_of(const std::string& pass, const Digest& key) {
  return file_stem(pass) + "-" + to_hex(key).substr(0, 32);
}

ObjectName artifact_name(const std::string& pass, const Digest& key) {
  return {without_label(pass), key};
}

ObjectName part_name(const std::string& pass, const Digest& part) {
  return {without_label(pass) + std::string(kPart), part};
}

ObjectName warnings_name(const std::string& pass, const Digest& key) {
  return {without_label(pass) + std::string(kWarnings), key};
}

// The number-th list of the parts of an artifact.
ObjectName list_name(const std::string& pass, const Digest& key, std::size_t number) {
  const ObjectName first{without_label(pass) + std::string(kPartList), key};
  if (number == 0) return first;
  DigestBuilder builder;
  builder.add(key);
  builder.add(std::to_string(number));
  return {first.kind, builder.finish()};
}

std::string text_of(const ObjectName& name) {
  return name.kind + " of key " + to_hex(name.key).substr(0, 32);
}

Result<std::optional<StoredBytes>> open_object_at(const std::filesystem::path& file,
                                                  const ObjectName& name) {
  Result<RegularFile> opened = open_regular_file(file.string());
  if (!opened && opened.error().code == ErrorCode::kFileNotFound) {
    return std::optional<StoredBytes>();
  }
  if (!opened) return opened.error();
  const std::uint64_t size = opened->size;
  const Result<SealedObject> object = open_object({std::move(opened->descriptor), size});
  if (!object) return in_file(object.error(), file.string());
  if (object->name != name) {
    return Error{ErrorCode::kBadLayer,
                 "found " + text_of(object->name) + ", expected " + text_of(name), file.string()};
  }
  return std::optional(object->content);
}

Result<ArtifactCache::Content> load_object(const std::filesystem::path& file,
                                           const ObjectName& name) {
  SIGHTLINE_ASSIGN(const std::optional<StoredBytes> content, open_object_at(file, name));
  if (!content) return ArtifactCache::Content();
  SIGHTLINE_ASSIGN(std::vector<std::byte> bytes, content->read(0, content->size()));
  return ArtifactCache::Content(std::move(bytes));
}

Result<void> store_object(const std::filesystem::path& file, const ObjectName& name,
                          const WriteInto& content) {
  return write_file_atomically(
      file, [&](const ByteSink& sink) { return write_sealed(name, content, sink); },
      IfExists::kReplace);
}

Result<void> store_object(const std::filesystem::path& file, const ObjectName& name,
                          std::span<const std::byte> content) {
  return store_object(file, name, [&](const ByteSink& sink) { return sink(content); });
}

std::vector<Digest> keys_of_parts(std::span<const std::byte> content) {
  std::vector<Digest> parts(content.size() / sizeof(Digest));
  if (!parts.empty()) std::memcpy(parts.data(), content.data(), parts.size() * sizeof(Digest));
  return parts;
}

}  // namespace

std::filesystem::path place_of(const ObjectName& name) {
  const auto pass_before = [&](std::string_view ending) {
    return name.kind.substr(0, name.kind.size() - ending.size());
  };
  if (name.kind.ends_with(kWarnings)) return stem_of(pass_before(kWarnings), name.key) + ".slw";
  if (name.kind.ends_with(kPartList)) return stem_of(pass_before(kPartList), name.key) + ".slp";
  if (!name.kind.ends_with(kPart)) return stem_of(name.kind, name.key) + ".sla";
  const std::string pass = pass_before(kPart);
  return std::filesystem::path(file_stem(pass) + kPartFolder) / (stem_of(pass, name.key) + ".sla");
}

std::vector<std::filesystem::path> places_of_parts(const ObjectName& list,
                                                   std::span<const std::byte> content) {
  std::vector<std::filesystem::path> places;
  if (!list.kind.ends_with(kPartList)) return places;
  const std::string pass = list.kind.substr(0, list.kind.size() - kPartList.size());
  for (const Digest& part : keys_of_parts(content)) {
    places.push_back(place_of(part_name(pass, part)));
  }
  return places;
}

ArtifactCache::ArtifactCache(std::filesystem::path directory) : directory_(std::move(directory)) {
  if (is_enabled()) remove_leftovers(directory_);
}

ArtifactCache ArtifactCache::to_look_at(std::filesystem::path directory) {
  ArtifactCache cache;
  cache.directory_ = std::move(directory);
  return cache;
}

bool ArtifactCache::has(const std::string& pass, const Digest& key) const {
  std::error_code failure;
  return is_enabled() && std::filesystem::is_regular_file(file_of(pass, key), failure);
}

std::filesystem::path ArtifactCache::file_of(const std::string& pass, const Digest& key) const {
  return directory_ / place_of(artifact_name(pass, key));
}

Result<ArtifactCache::Content> ArtifactCache::load(const std::string& pass,
                                                   const Digest& key) const {
  if (!is_enabled()) return Content();
  return load_object(file_of(pass, key), artifact_name(pass, key));
}

Result<void> ArtifactCache::store(const std::string& pass, const Digest& key,
                                  std::span<const std::byte> content) const {
  if (!is_enabled()) return {};
  return store_object(file_of(pass, key), artifact_name(pass, key), content);
}

Result<std::optional<StoredBytes>> ArtifactCache::open(const std::string& pass,
                                                       const Digest& key) const {
  if (!is_enabled()) return std::optional<StoredBytes>();
  return open_object_at(file_of(pass, key), artifact_name(pass, key));
}

Result<void> ArtifactCache::store(const std::string& pass, const Digest& key,
                                  const WriteInto& content) const {
  if (!is_enabled()) return {};
  return store_object(file_of(pass, key), artifact_name(pass, key), content);
}

void ArtifactCache::mark_used(const std::string& pass, const Digest& key) const {
  if (!is_enabled()) return;
  const auto touch = [&](const ObjectName& name) {
    const std::filesystem::path file = directory_ / place_of(name);
    return ::utimensat(AT_FDCWD, file.c_str(), nullptr, AT_SYMLINK_NOFOLLOW) == 0;
  };
  touch(artifact_name(pass, key));
  touch(warnings_name(pass, key));
  std::size_t list = 0;
  while (touch(list_name(pass, key, list))) ++list;
}

Result<ArtifactCache::Content> ArtifactCache::load_part(const std::string& pass,
                                                        const Digest& part) const {
  if (!is_enabled()) return Content();
  const ObjectName name = part_name(pass, part);
  return load_object(directory_ / place_of(name), name);
}

void ArtifactCache::store_part(const std::string& pass, const Digest& part,
                               std::span<const std::byte> content) const {
  if (!is_enabled()) return;
  const ObjectName name = part_name(pass, part);
  (void)store_object(directory_ / place_of(name), name, content);
}

void ArtifactCache::store_part_list(const std::string& pass, const Digest& key,
                                    std::span<const Digest> parts, std::size_t number) const {
  if (!is_enabled()) return;
  const ObjectName name = list_name(pass, key, number);
  (void)store_object(directory_ / place_of(name), name, std::as_bytes(parts));
}

std::optional<ArtifactCache::PartCount> ArtifactCache::part_count(const std::string& pass,
                                                                  const Digest& key) const {
  if (!is_enabled()) return std::nullopt;
  std::set<Digest> parts;
  std::size_t lists = 0;
  for (;; ++lists) {
    const ObjectName name = list_name(pass, key, lists);
    const Result<Content> content = load_object(directory_ / place_of(name), name);
    if (!content || !*content || (*content)->size() % sizeof(Digest) != 0) break;
    for (const Digest& part : keys_of_parts(**content)) parts.insert(part);
  }
  if (lists == 0) return std::nullopt;
  PartCount count;
  count.all = parts.size();
  for (const Digest& part : parts) {
    std::error_code failure;
    if (std::filesystem::exists(directory_ / place_of(part_name(pass, part)), failure)) {
      ++count.there;
    }
  }
  return count;
}

Result<void> ArtifactCache::store_warnings(const std::string& pass, const Digest& key,
                                           const std::vector<std::string>& warnings) const {
  if (!is_enabled() || warnings.empty()) return {};
  const ObjectName name = warnings_name(pass, key);
  ByteWriter writer;
  writer.put<std::uint64_t>(warnings.size());
  for (const std::string& warning : warnings) writer.put_string(warning);
  return store_object(directory_ / place_of(name), name, writer.bytes());
}

std::vector<std::string> ArtifactCache::load_warnings(const std::string& pass,
                                                      const Digest& key) const {
  if (!is_enabled()) return {};
  const ObjectName name = warnings_name(pass, key);
  const Result<Content> content = load_object(directory_ / place_of(name), name);
  if (!content || !*content) return {};
  ByteReader reader(**content);
  std::vector<std::string> warnings(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& warning : warnings) reader.get_string(warning);
  return reader.at_end() ? warnings : std::vector<std::string>{};
}

std::string ArtifactCache::last_record(const std::string& pass) const {
  if (!is_enabled()) return {};
  const std::filesystem::path file = directory_ / (file_stem(pass) + ".last");
  const Result<std::string> text = read_short_text(file, kLargestRecord);
  return text ? *text : std::string();
}

Result<void> ArtifactCache::store_record(const std::string& pass, const std::string& record) const {
  if (!is_enabled()) return {};
  return write_file_atomically(directory_ / (file_stem(pass) + ".last"), record,
                               IfExists::kReplace);
}

}  // namespace sightline
