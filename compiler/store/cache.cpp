#include "compiler/store/cache.h"

#include <algorithm>

#include "formats/base/atomic_file.h"

namespace sightline {
namespace {

// A pass may be named "ingest:localization", a file had better not.
std::string file_stem(std::string pass) {
  std::ranges::replace(pass, ':', '.');
  return pass;
}

}  // namespace

ArtifactCache::ArtifactCache(std::filesystem::path directory) : directory_(std::move(directory)) {
  if (directory_.empty()) return;
  std::error_code failure;
  std::filesystem::directory_iterator files(directory_, failure);
  if (failure) return;
  for (const std::filesystem::directory_entry& entry : files) {
    if (entry.path().extension() == ".tmp") std::filesystem::remove(entry.path(), failure);
  }
}

std::filesystem::path ArtifactCache::file_of(const std::string& pass, const Digest& key) const {
  // 128 bits of the key: names stay readable and no two keys ever meet.
  return directory_ / (file_stem(pass) + "-" + to_hex(key).substr(0, 32) + ".sla");
}

std::optional<std::vector<std::byte>> ArtifactCache::load(const std::string& pass,
                                                          const Digest& key) const {
  if (!is_enabled()) return std::nullopt;
  Result<std::vector<std::byte>> bytes = read_file(file_of(pass, key));
  if (!bytes) return std::nullopt;
  return std::move(*bytes);
}

Result<void> ArtifactCache::store(const std::string& pass, const Digest& key,
                                  std::span<const std::byte> sealed) const {
  if (!is_enabled()) return {};
  return write_file_atomically(file_of(pass, key), sealed, IfExists::kReplace);
}

std::filesystem::path ArtifactCache::parts_of(const std::string& pass, const Digest& key) const {
  return file_of(pass, key).replace_extension(".parts");
}

std::optional<std::vector<std::byte>> ArtifactCache::load_part(const std::string& pass,
                                                               const Digest& key,
                                                               std::size_t part) const {
  if (!is_enabled()) return std::nullopt;
  Result<std::vector<std::byte>> bytes = read_file(parts_of(pass, key) / std::to_string(part));
  if (!bytes) return std::nullopt;
  return std::move(*bytes);
}

void ArtifactCache::store_part(const std::string& pass, const Digest& key, std::size_t part,
                               std::span<const std::byte> bytes) const {
  if (!is_enabled()) return;
  (void)write_file_atomically(parts_of(pass, key) / std::to_string(part), bytes,
                              IfExists::kReplace);
}

void ArtifactCache::remove_parts(const std::string& pass, const Digest& key) const {
  std::error_code failure;
  if (is_enabled()) std::filesystem::remove_all(parts_of(pass, key), failure);
}

std::string ArtifactCache::last_record(const std::string& pass) const {
  if (!is_enabled()) return {};
  const Result<std::string> text = read_text_file(directory_ / (file_stem(pass) + ".last"));
  return text ? *text : std::string();
}

Result<void> ArtifactCache::store_record(const std::string& pass, const std::string& record) const {
  if (!is_enabled()) return {};
  return write_file_atomically(directory_ / (file_stem(pass) + ".last"), record,
                               IfExists::kReplace);
}

}  // namespace sightline
