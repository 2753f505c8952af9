#include "compiler/store/prune.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <string>
#include <utility>

#include "compiler/store/cache.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/files/temporary_name.h"

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
               folder.string()};
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

// And the folder of parts that is empty then.
Result<void> remove_object(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) {
    return write_failure(path, "cannot remove", errno);
  }
  if (path.parent_path().extension() == ".parts") {
    (void)::rmdir(path.parent_path().c_str());  // fails as long as it holds something
  }
  return {};
}

class Look {
 public:
  Look(fs::path folder, std::optional<std::chrono::hours> unused_for) : folder_(std::move(folder)) {
    if (unused_for) oldest_used_ = fs::file_time_type::clock::now() - *unused_for;
  }

  Result<CacheContents> run() {
    SIGHTLINE_ASSIGN(Entries entries, entries_of(folder_));
    // Folders last: what lies beside them says which of their parts are used.
    std::stable_partition(entries.begin(), entries.end(), [](const fs::directory_entry& entry) {
      std::error_code failure;
      return !entry.is_directory(failure);
    });
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
    } else if (is_object && is_unused(entry)) {
      contents_.unused.push_back(path);
      contents_.unused_bytes += size;
    } else if (is_object) {
      contents_.object_count += 1;
      contents_.object_bytes += size;
      if (oldest_used_) note_parts(path);
    }
  }

  [[nodiscard]] static Result<SealedObject> object_in(const fs::path& path) {
    SIGHTLINE_ASSIGN(RegularFile file, open_regular_file(path.string()));
    const std::uint64_t size = file.size;
    return open_object({std::move(file.descriptor), size});
  }

  [[nodiscard]] bool is_at_its_place(const fs::path& path) const {
    const Result<SealedObject> object = object_in(path);
    return object && folder_ / place_of(object->name) == path;
  }

  [[nodiscard]] bool is_unused(const fs::directory_entry& entry) const {
    if (!oldest_used_ || used_parts_.contains(entry.path())) return false;
    std::error_code failure;
    const fs::file_time_type used = entry.last_write_time(failure);
    return !failure && used < *oldest_used_;
  }

  // Parts that a used list names.
  void note_parts(const fs::path& path) {
    if (path.extension() != ".slp") return;
    const Result<SealedObject> list = object_in(path);
    if (!list) return;
    const Result<std::vector<std::byte>> content = list->content.read(0, list->content.size());
    if (!content) return;
    for (const fs::path& part : places_of_parts(list->name, *content)) {
      used_parts_.insert(folder_ / part);
    }
  }

  fs::path folder_;
  std::optional<fs::file_time_type> oldest_used_;
  std::set<fs::path> used_parts_;
  CacheContents contents_;
};

}  // namespace

Result<CacheContents> look_at_cache(const fs::path& folder,
                                    std::optional<std::chrono::hours> unused_for) {
  return Look(folder, unused_for).run();
}

Result<void> prune_cache(const CacheContents& contents) {
  for (const std::vector<fs::path>* paths : {&contents.useless, &contents.unused}) {
    for (const fs::path& path : *paths) SIGHTLINE_TRY(remove_object(path));
  }
  return {};
}

}  // namespace sightline
