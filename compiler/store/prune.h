#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What lies in a cache.
struct CacheContents {
  std::uint64_t object_count = 0;
  std::uint64_t object_bytes = 0;
  std::uint64_t busy_count = 0;  // unfinished files of processes that run here
  // Of no use to any run: unfinished files of processes that are gone, of other machines and of
  // earlier boots; objects that are damaged or lie where others belong.
  std::vector<std::filesystem::path> useless;
  std::uint64_t useless_bytes = 0;
  // Whole objects that no run used for as long as was asked about; parts that the list of a younger
  // artifact names are used.
  std::vector<std::filesystem::path> unused;
  std::uint64_t unused_bytes = 0;
};

// Reads every object. Files that are not named as the cache names its own are left out. Without
// `unused_for` nothing counts as unused. Errors: file-not-found (no folder), cannot-read.
Result<CacheContents> look_at_cache(const std::filesystem::path& folder,
                                    std::optional<std::chrono::hours> unused_for = std::nullopt);

// Removes what is useless or unused. Not while another machine works in the same folder: its
// unfinished files are among them, and that run would fail. Error: cannot-write.
Result<void> prune_cache(const CacheContents& contents);

}  // namespace sightline
