#include "formats/base/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <set>

#include "formats/base/files/file_system_gap.h"
#include "formats/base/files/regular_file.h"
#include "formats/base/files/temporary_name.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// A name that exists already is foreign, whatever it says; more than a few of them are meant.
constexpr int kMostTries = 16;

Error output_exists(const fs::path& path) {
  return {ErrorCode::kOutputExists,
          "the output exists already. Choose another name, or replace it with --force",
          path.string()};
}

Error out_of_memory(const fs::path& path, std::uint64_t size) {
  return {ErrorCode::kOutOfMemory, concat("not enough memory for the file's ", size, " bytes"),
          path.string()};
}

// Whether the path is a mount point, as a file is that a container got from outside.
bool is_mounted(const fs::path& path) {
  struct statx status {};
  if (::statx(AT_FDCWD, path.c_str(), AT_SYMLINK_NOFOLLOW, STATX_TYPE, &status) != 0) return false;
  return (status.stx_attributes & status.stx_attributes_mask & STATX_ATTR_MOUNT_ROOT) != 0;
}

// An unfinished file beside the target. Gone with its owner unless it was kept.
struct UnfinishedFile {
  fs::path path;
  Descriptor descriptor;
  bool kept = false;

  UnfinishedFile() = default;
  UnfinishedFile(UnfinishedFile&&) = default;
  UnfinishedFile& operator=(UnfinishedFile&&) = delete;
  ~UnfinishedFile() {
    if (!path.empty() && !kept) ::unlink(path.c_str());
  }
};

// Never through a link, and never a file that is there.
Result<UnfinishedFile> create_beside(const fs::path& target, const fs::path& folder, int mode) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  int number = EEXIST;
  for (int i = 0; i < kMostTries && number == EEXIST; ++i) {
    const fs::path path = folder / temporary_name();
    Descriptor descriptor(::open(path.c_str(), kFlags, mode));
    number = errno;
    if (descriptor.number() < 0) continue;
    UnfinishedFile file;
    file.path = path;
    file.descriptor = std::move(descriptor);
    return file;
  }
  return write_failure(target, "cannot create the file", number);
}

Result<void> make_folder(const fs::path& folder) {
  std::error_code failure;
  std::error_code ignored;
  fs::create_directories(folder, failure);
  if (!failure || fs::is_directory(folder, ignored)) return {};
  return write_failure(folder, "cannot make the folder", failure.value());
}

// The file that is replaced keeps its mode and group, and its owner where root replaces it. Where
// another group may not be given, that of the new file gets no more rights than all others have.
// What only its owner may read (0600) never becomes readable by more.
void keep_rights(const fs::path& replaced, const Descriptor& file, int most) {
  struct stat old {};
  struct stat made {};
  if (::lstat(replaced.c_str(), &old) != 0 || !S_ISREG(old.st_mode)) return;
  if (::fstat(file.number(), &made) != 0) return;
  mode_t mode = old.st_mode & 0777;
  if (old.st_uid != made.st_uid) (void)::fchown(file.number(), old.st_uid, old.st_gid);
  if (old.st_gid != made.st_gid && ::fchown(file.number(), uid_t(-1), old.st_gid) != 0) {
    mode = (mode & 0707) | ((mode & 0007) << 3);
  }
  if (most == 0600) mode &= 0600;
  (void)::fchmod(file.number(), mode);
}

// Between the check and the rename another process may have written the file.
int put_in_place(const fs::path& from, const fs::path& to, IfExists if_exists) {
  if (if_exists == IfExists::kRefuse) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    const int number = errno;
    if (!is_gap(FileSystemGap::kRenameWithoutReplacing, number)) return number;
    // Then what the check saw must do.
    report_gap(FileSystemGap::kRenameWithoutReplacing, to.string(), number);
  }
  return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

Result<void> sync_file(const Descriptor& file, const fs::path& path) {
  if (::fsync(file.number()) == 0) return {};
  const int number = errno;
  if (!is_gap(FileSystemGap::kSync, number)) return write_failure(path, "cannot sync", number);
  report_gap(FileSystemGap::kSync, path.string(), number);
  return {};
}

// After the rename: the directory entry itself reaches the disk. Some file systems cannot sync a
// directory; the file is whole then all the same.
void sync_directory(const fs::path& directory) {
  const Descriptor descriptor(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.number() >= 0) ::fsync(descriptor.number());
}

// Once a folder and process: reading a large folder before each file would cost more than it.
void remove_leftovers_once(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> done;
  const std::lock_guard<std::mutex> lock(mutex);
  if (done.insert(folder).second) remove_leftovers(folder);
}

Result<void> read_all(const RegularFile& file, const fs::path& path, FileContent& content) {
  std::size_t done = 0;
  while (done < content.bytes().size()) {
    const ssize_t count =
        ::read(file.descriptor.number(), content.data() + done, content.bytes().size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return Error{ErrorCode::kCannotRead,
                   count < 0 ? std::strerror(errno) : "the file became shorter while it was read",
                   path.string(), concat("byte ", done)};
    }
    done += static_cast<std::size_t>(count);
  }
  return {};
}

}  // namespace

int write_all(const Descriptor& file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file.number(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

Error write_failure(const fs::path& path, const std::string& what, int number) {
  // A limit on the size of files (ulimit -f) is met as a full disk is.
  const bool is_full = number == ENOSPC || number == EDQUOT || number == EFBIG;
  return {is_full ? ErrorCode::kDiskFull : ErrorCode::kCannotWrite,
          concat(what, ": ", std::strerror(number)), path.string()};
}

Result<void> check_output(const fs::path& path, IfExists if_exists) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) {
    if (errno == ENAMETOOLONG)
      return write_failure(path, "the output cannot have this name", errno);
    return {};  // other failures show when it is written
  }
  if (!S_ISREG(status.st_mode)) {
    return Error{ErrorCode::kCannotWrite,
                 "the output is a link, folder, pipe or device; only a regular file is replaced. "
                 "Remove it or choose another name",
                 path.string()};
  }
  if (is_mounted(path)) {
    return Error{ErrorCode::kCannotWrite,
                 "a file is mounted here, which cannot be replaced; mount its folder instead, or "
                 "choose another name",
                 path.string()};
  }
  if (if_exists == IfExists::kRefuse) return output_exists(path);
  return {};
}

Result<void> write_file_atomically(const fs::path& path, const WriteInto& write, IfExists if_exists,
                                   FileAccess access) {
  SIGHTLINE_TRY(check_output(path, if_exists));
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  SIGHTLINE_TRY(make_folder(folder));
  remove_leftovers_once(folder);
  const int mode = access == FileAccess::kOwner ? 0600 : 0644;
  SIGHTLINE_ASSIGN(UnfinishedFile file, create_beside(path, folder, mode));
  if (if_exists == IfExists::kReplace) keep_rights(path, file.descriptor, mode);
  SIGHTLINE_TRY(write([&](std::span<const std::byte> piece) -> Result<void> {
    const int number = write_all(file.descriptor, piece);
    if (number != 0) return write_failure(path, "cannot write", number);
    return {};
  }));
  SIGHTLINE_TRY(sync_file(file.descriptor, path));
  if (const int number = file.descriptor.close(); number != 0) {
    return write_failure(path, "cannot close", number);
  }
  if (const int number = put_in_place(file.path, path, if_exists); number != 0) {
    if (number == EEXIST) return output_exists(path);
    return write_failure(path, "cannot rename the finished file to its name", number);
  }
  file.kept = true;
  sync_directory(folder);
  return {};
}

Result<void> write_file_atomically(const fs::path& path, std::span<const std::byte> bytes,
                                   IfExists if_exists, FileAccess access) {
  return write_file_atomically(
      path, [&](const ByteSink& file) { return file(bytes); }, if_exists, access);
}

Result<void> write_file_atomically(const fs::path& path, std::string_view text, IfExists if_exists,
                                   FileAccess access) {
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), if_exists,
                               access);
}

Result<FileContent> read_file_content(const fs::path& path) {
  SIGHTLINE_ASSIGN(const RegularFile file, open_regular_file(path.string()));
  try {
    FileContent content(file.size);
    SIGHTLINE_TRY(read_all(file, path, content));
    return content;
  } catch (const std::bad_alloc&) {  // a file with a hole may say any size
    return out_of_memory(path, file.size);
  }
}

Result<std::vector<std::byte>> read_file(const fs::path& path) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(path));
  try {
    return std::vector<std::byte>(content.bytes().begin(), content.bytes().end());
  } catch (const std::bad_alloc&) {
    return out_of_memory(path, content.bytes().size());
  }
}

Result<std::string> read_text_file(const fs::path& path) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(path));
  try {
    return std::string(reinterpret_cast<const char*>(content.bytes().data()),
                       content.bytes().size());
  } catch (const std::bad_alloc&) {
    return out_of_memory(path, content.bytes().size());
  }
}

Result<std::string> read_short_text(const fs::path& path, std::size_t most_bytes) {
  SIGHTLINE_ASSIGN(std::string text, read_beginning(path.string(), most_bytes + 1));
  if (text.size() <= most_bytes) return text;
  return Error{ErrorCode::kTooLarge,
               concat("more than ", most_bytes, " bytes, too many for a file of this kind"),
               path.string()};
}

}  // namespace sightline
