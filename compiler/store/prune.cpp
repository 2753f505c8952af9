#include "compiler/store/prune.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

#include "compiler/store/cache.h"
#include "formats/base/atomic_file.h"
#include "formats/base/temporary_name.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

using Entries = std::vector<fs::directory_entry>;

Result<Entries> entries_of(const fs::path& folder) {
  Entries entries;
  std::error_code failure;
  fs::directory_iterator entry(folder, failure);
  for (; !failure && entry != fs::directory_iterator(); entry.increment(failure)) {
    entries.push_back(*entry);
  }
  if (!failure) return entries;
  const bool is_missing = failure == std::errc::no_such_file_or_directory;
  return Error{is_missing ? ErrorCode::kFileNotFound : ErrorCode::kCannotRead, failure.message(),
               folder.string(), ""};
}

bool is_hexadecimal(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// "build-ndt-<32 digits>.sla": what else ends so is not the cache's.
bool is_named_as(const fs::path& path, std::string_view ending) {
  constexpr std::size_t kDigits = 32;
  const std::string stem = path.stem().string();
  return path.extension() == ending && stem.size() > kDigits + 1 &&
         stem[stem.size() - kDigits - 1] == '-' &&
         is_hexadecimal(std::string_view(stem).substr(stem.size() - kDigits));
}

class Look {
 public:
  explicit Look(fs::path folder) : folder_(std::move(folder)) {}

  Result<CacheContents> run() {
    SIGHTLINE_ASSIGN(const Entries entries, entries_of(folder_));
    for (const fs::directory_entry& entry : entries) {
      const fs::path& path = entry.path();
      std::error_code failure;
      const bool is_folder = entry.is_directory(failure) && !entry.is_symlink(failure);
      if (is_folder && path.extension() == ".parts") {
        SIGHTLINE_TRY(look_at_parts(path));
      } else {
        look_at_entry(entry);
      }
    }
    return std::move(contents_);
  }

 private:
  Result<void> look_at_parts(const fs::path& parts) {
    SIGHTLINE_ASSIGN(const Entries entries, entries_of(parts));
    for (const fs::directory_entry& entry : entries) look_at_entry(entry);
    return {};
  }

  void look_at_entry(const fs::directory_entry& entry) {
    std::error_code failure;
    if (!entry.is_regular_file(failure) || entry.is_symlink(failure)) return;
    const fs::path& path = entry.path();
    const bool is_object =
        is_named_as(path, ".sla") || is_named_as(path, ".slw") || is_named_as(path, ".slp");
    const TemporaryOwner owner = owner_of(entry.path().filename().string());
    const std::uint64_t size = entry.file_size(failure);
    if (failure) return;  // gone meanwhile
    if (owner == TemporaryOwner::kAlive) {
      contents_.busy_count += 1;
    } else if (owner != TemporaryOwner::kNone || (is_object && !is_at_its_place(path))) {
      contents_.useless.push_back(path);
      contents_.useless_bytes += size;
    } else if (is_object) {
      contents_.object_count += 1;
      contents_.object_bytes += size;
    }
  }

  [[nodiscard]] bool is_at_its_place(const fs::path& path) const {
    Result<RegularFile> file = open_regular_file(path.string());
    if (!file) return false;
    const std::uint64_t size = file->size;
    const Result<SealedObject> object = open_object({std::move(file->descriptor), size});
    return object && folder_ / place_of(object->name) == path;
  }

  fs::path folder_;
  CacheContents contents_;
};

}  // namespace

Result<CacheContents> look_at_cache(const fs::path& folder) { return Look(folder).run(); }

Result<void> prune_cache(const CacheContents& contents) {
  for (const fs::path& path : contents.useless) {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) {
      return write_failure(path, "cannot remove", errno);
    }
    if (path.parent_path().extension() == ".parts") {
      (void)::rmdir(path.parent_path().c_str());  // fails as long as it holds something
    }
  }
  return {};
}

}  // namespace sightline
