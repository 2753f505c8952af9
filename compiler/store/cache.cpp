#include "compiler/store/cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <span>
#include <vector>

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
  return concat(file_stem(pass), "-", to_hex(key).substr(0, 32));
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
  return concat(name.kind, " of key ", to_hex(name.key).substr(0, 32));
}

Result<std::optional<StoredBytes>> open_object_in(const std::filesystem::path& folder,
                                                  const ObjectName& name) {
  const std::filesystem::path file = folder / place_of(name);
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
                 concat("found ", text_of(object->name), ", expected ", text_of(name)),
                 file.string()};
  }
  return std::optional(object->content);
}

Result<ArtifactCache::Content> load_object(const std::filesystem::path& folder,
                                           const ObjectName& name) {
  SIGHTLINE_ASSIGN(const std::optional<StoredBytes> content, open_object_in(folder, name));
  if (!content) return ArtifactCache::Content();
  SIGHTLINE_ASSIGN(std::vector<std::byte> bytes, content->read(0, content->size()));
  return ArtifactCache::Content(std::move(bytes));
}

Result<void> store_object(const std::filesystem::path& folder, const ObjectName& name,
                          const WriteInto& content) {
  return write_file_atomically(
      folder / place_of(name),
      [&](const ByteSink& sink) { return write_sealed(name, content, sink); }, IfExists::kReplace);
}

Result<void> store_object(const std::filesystem::path& folder, const ObjectName& name,
                          std::span<const std::byte> content) {
  return store_object(folder, name, [&](const ByteSink& sink) { return sink(content); });
}

std::vector<Digest> keys_of_parts(std::span<const std::byte> content) {
  std::vector<Digest> parts(content.size() / sizeof(Digest));
  if (!parts.empty()) std::memcpy(parts.data(), content.data(), parts.size() * sizeof(Digest));
  return parts;
}

constexpr std::string_view kMagic("SLO\x1a", 4);
constexpr std::size_t kTailSize = 32 + 8 + 4 + 32 + 4;  // behind the kind

Digest get_digest(ByteReader& reader) {
  Digest digest{};
  for (std::uint8_t& byte : digest) reader.get(byte);
  return digest;
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
  return is_enabled() &&
         std::filesystem::is_regular_file(directory_ / place_of(artifact_name(pass, key)), failure);
}

Result<ArtifactCache::Content> ArtifactCache::load(const std::string& pass,
                                                   const Digest& key) const {
  if (!is_enabled()) return Content();
  return load_object(directory_, artifact_name(pass, key));
}

Result<void> ArtifactCache::store(const std::string& pass, const Digest& key,
                                  std::span<const std::byte> content) const {
  if (!is_enabled()) return {};
  return store_object(directory_, artifact_name(pass, key), content);
}

Result<std::optional<StoredBytes>> ArtifactCache::open(const std::string& pass,
                                                       const Digest& key) const {
  if (!is_enabled()) return std::optional<StoredBytes>();
  return open_object_in(directory_, artifact_name(pass, key));
}

Result<void> ArtifactCache::store(const std::string& pass, const Digest& key,
                                  const WriteInto& content) const {
  if (!is_enabled()) return {};
  return store_object(directory_, artifact_name(pass, key), content);
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
  return load_object(directory_, part_name(pass, part));
}

void ArtifactCache::store_part(const std::string& pass, const Digest& part,
                               std::span<const std::byte> content) const {
  if (!is_enabled()) return;
  (void)store_object(directory_, part_name(pass, part), content);
}

void ArtifactCache::store_part_list(const std::string& pass, const Digest& key,
                                    std::span<const Digest> parts, std::size_t number) const {
  if (!is_enabled()) return;
  (void)store_object(directory_, list_name(pass, key, number), std::as_bytes(parts));
}

std::optional<ArtifactCache::PartCount> ArtifactCache::part_count(const std::string& pass,
                                                                  const Digest& key) const {
  if (!is_enabled()) return std::nullopt;
  std::set<Digest> parts;
  std::size_t lists = 0;
  for (;; ++lists) {
    const Result<Content> content = load_object(directory_, list_name(pass, key, lists));
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
  ByteWriter writer;
  writer.put<std::uint64_t>(warnings.size());
  for (const std::string& warning : warnings) writer.put_string(warning);
  return store_object(directory_, warnings_name(pass, key), writer.bytes());
}

std::vector<std::string> ArtifactCache::load_warnings(const std::string& pass,
                                                      const Digest& key) const {
  if (!is_enabled()) return {};
  const Result<Content> content = load_object(directory_, warnings_name(pass, key));
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

Result<void> ArtifactCache::check_writable() const {
  if (!is_enabled()) return {};
  std::error_code failure;
  std::filesystem::path folder = std::filesystem::absolute(directory_, failure);
  while (folder.has_relative_path() && !std::filesystem::exists(folder, failure)) {
    folder = folder.parent_path();
  }
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
  return write_failure(directory_, "no file can be made in " + folder.string(), errno);
}

Result<void> write_sealed(const ObjectName& name, const WriteInto& content, const ByteSink& sink) {
  Sha256Stream digest;
  std::uint64_t size = 0;
  SIGHTLINE_TRY(content([&](std::span<const std::byte> piece) -> Result<void> {
    digest.add(piece);
    size += piece.size();
    return sink(piece);
  }));
  ByteWriter seal;
  seal.append(name.kind.data(), name.kind.size());
  seal.append(name.key.data(), name.key.size());
  seal.put(size);
  seal.put<std::uint32_t>(static_cast<std::uint32_t>(name.kind.size()));
  digest.add(seal.bytes());
  const Digest all = digest.finish();
  seal.append(all.data(), all.size());
  seal.append(kMagic.data(), kMagic.size());
  return sink(seal.bytes());
}

Result<SealedObject> open_object(const StoredBytes& sealed) {
  const Error none{ErrorCode::kBadMagic, "not a cache object, or cut short"};
  if (sealed.size() < kTailSize) return none;
  const std::uint64_t before_tail = sealed.size() - kTailSize;
  SIGHTLINE_ASSIGN(const std::vector<std::byte> tail, sealed.read(before_tail, kTailSize));
  const std::span<const std::byte> magic = std::span(tail).last(kMagic.size());
  if (std::memcmp(magic.data(), kMagic.data(), magic.size()) != 0) return none;
  ByteReader reader(tail);
  const auto key = get_digest(reader);
  const auto content_size = reader.get<std::uint64_t>();
  const auto kind_size = reader.get<std::uint32_t>();
  const auto digest = get_digest(reader);
  if (content_size > before_tail || before_tail - content_size != kind_size) {
    return Error{ErrorCode::kOutOfBounds, "its lengths do not match the file"};
  }
  Sha256Stream found;
  const StoredBytes digested = sealed.part(0, sealed.size() - digest.size() - kMagic.size());
  SIGHTLINE_TRY(digested.visit([&](std::span<const std::byte> piece) -> Result<void> {
    found.add(piece);
    return {};
  }));
  if (found.finish() != digest) {
    return Error{ErrorCode::kDigestMismatch, "damaged: its SHA-256 does not match"};
  }
  SealedObject object{{std::string(kind_size, '\0'), key}, sealed.part(0, content_size)};
  SIGHTLINE_TRY(sealed.read(content_size, std::as_writable_bytes(std::span(object.name.kind))));
  return object;
}

}  // namespace sightline
