#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"

namespace sightline {

// Finished artifacts on disk, by the key of the pass that made them, and for each pass a record of
// what its last key was made of, so that a rebuild can be explained. Files appear whole or not at
// all, so a cache survives an interruption at any moment.
class ArtifactCache {
 public:
  // An empty directory name keeps nothing. Removes unfinished files of an interrupted run.
  explicit ArtifactCache(std::filesystem::path directory);

  // The sealed bytes, where there are any.
  [[nodiscard]] std::optional<std::vector<std::byte>> load(const std::string& pass,
                                                           const Digest& key) const;
  [[nodiscard]] Result<void> store(const std::string& pass, const Digest& key,
                                   std::span<const std::byte> sealed) const;

  // Parts of an artifact that is not finished yet, and their end: in a folder of the key's own. A
  // part that cannot be kept is made again by the next run, so failures are not told.
  [[nodiscard]] std::optional<std::vector<std::byte>> load_part(const std::string& pass,
                                                                const Digest& key,
                                                                std::size_t part) const;
  void store_part(const std::string& pass, const Digest& key, std::size_t part,
                  std::span<const std::byte> bytes) const;
  void remove_parts(const std::string& pass, const Digest& key) const;

  // Lines "name = value" that made the last key of this pass; empty where it never ran.
  [[nodiscard]] std::string last_record(const std::string& pass) const;
  [[nodiscard]] Result<void> store_record(const std::string& pass, const std::string& record) const;

  [[nodiscard]] bool is_enabled() const { return !directory_.empty(); }

 private:
  [[nodiscard]] std::filesystem::path parts_of(const std::string& pass, const Digest& key) const;
  [[nodiscard]] std::filesystem::path file_of(const std::string& pass, const Digest& key) const;
  std::filesystem::path directory_;
};

}  // namespace sightline
