#include "formats/map/delta/part_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "formats/base/files/file_system_gap.h"

namespace sightline {
namespace {

// A link would let any program that may write to the folder choose another file to be overwritten;
// a pipe would wait for ever.
constexpr int kFlags = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;

Error failure(ErrorCode code, const std::filesystem::path& path, const char* what, int number) {
  const bool is_full = number == ENOSPC || number == EDQUOT || number == EFBIG;
  return {is_full ? ErrorCode::kDiskFull : code, concat(what, ": ", std::strerror(number)),
          path.string()};
}

// Before the lock was had, the process that held it may have renamed the file to the map itself.
bool is_still_called(const std::filesystem::path& path, const struct stat& file) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && status.st_dev == file.st_dev &&
         status.st_ino == file.st_ino;
}

}  // namespace

PartFile::PartFile(PartFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      is_own_(other.is_own_),
      offset_(other.offset_),
      kept_(other.kept_),
      is_comparing_(other.is_comparing_),
      found_(std::move(other.found_)) {}

PartFile::~PartFile() {
  if (descriptor_ < 0) return;
  struct stat status {};
  const bool is_empty = is_own_ && ::fstat(descriptor_, &status) == 0 && status.st_size == 0;
  if (is_empty && is_still_called(path_, status)) (void)::unlink(path_.c_str());
  ::close(descriptor_);
}

Result<PartFile> PartFile::open(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), kFlags, 0644);
  if (descriptor < 0) return failure(ErrorCode::kCannotOpen, path, "cannot open", errno);
  PartFile file(path, descriptor);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) || status.st_nlink != 1) {
    return Error{ErrorCode::kCannotOpen, "not a regular file, or it has several hard links",
                 path.string()};
  }
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    const int number = errno;
    if (is_gap(FileSystemGap::kLock, number)) return open_anew(path, number);
    return failure(ErrorCode::kCannotOpen, path, "another process is using it", number);
  }
  if (!is_still_called(path, status)) {
    return Error{ErrorCode::kCannotOpen, "another process has just finished it; try again",
                 path.string()};
  }
  file.is_own_ = true;
  return file;
}

// Without locks another process may hold the file that is there, and would write into it even when
// it has become the map: this one takes no file but a new one.
Result<PartFile> PartFile::open_anew(const std::filesystem::path& path, int number) {
  report_gap(FileSystemGap::kLock, path.string(), number);
  (void)::unlink(path.c_str());
  const int descriptor = ::open(path.c_str(), kFlags | O_EXCL, 0644);
  if (descriptor < 0) return failure(ErrorCode::kCannotOpen, path, "cannot open", errno);
  PartFile file(path, descriptor);
  file.is_own_ = true;
  return file;
}

Result<bool> PartFile::is_there(std::span<const std::byte> bytes) {
  found_.resize(bytes.size());
  std::size_t done = 0;
  while (done < found_.size()) {
    const ssize_t count = ::pread(descriptor_, found_.data() + done, found_.size() - done,
                                  static_cast<off_t>(offset_ + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(ErrorCode::kCannotRead, path_, "cannot read", errno);
    if (count == 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return std::ranges::equal(found_, bytes);
}

Result<void> PartFile::put(std::span<const std::byte> bytes) {
  if (is_comparing_) {
    SIGHTLINE_ASSIGN(const bool there, is_there(bytes));
    if (there) {
      offset_ += bytes.size();
      kept_ = offset_;
      return {};
    }
    is_comparing_ = false;
    if (::ftruncate(descriptor_, static_cast<off_t>(offset_)) != 0) {
      return failure(ErrorCode::kCannotWrite, path_, "cannot shorten", errno);
    }
  }
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset_));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(ErrorCode::kCannotWrite, path_, "cannot write", errno);
    offset_ += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Result<void> PartFile::finish() {
  if (::ftruncate(descriptor_, static_cast<off_t>(offset_)) != 0) {
    return failure(ErrorCode::kCannotWrite, path_, "cannot shorten", errno);
  }
  if (::fsync(descriptor_) == 0) return {};
  const int number = errno;
  if (!is_gap(FileSystemGap::kSync, number)) {
    return failure(ErrorCode::kCannotWrite, path_, "cannot sync", number);
  }
  report_gap(FileSystemGap::kSync, path_.string(), number);
  return {};
}

void PartFile::discard() { (void)::ftruncate(descriptor_, 0); }

}  // namespace sightline
