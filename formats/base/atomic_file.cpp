#include "formats/base/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace sightline {
namespace {

Error write_error(const std::filesystem::path& path, const char* what, int number) {
  const bool full = number == ENOSPC || number == EDQUOT;
  return {full ? ErrorCode::kDiskFull : ErrorCode::kCannotWrite,
          std::string(what) + ": " + std::strerror(number), path.string(), ""};
}

// Owns a descriptor, and the unfinished file until it is kept.
struct UnfinishedFile {
  std::filesystem::path path;
  int descriptor = -1;
  bool kept = false;
  ~UnfinishedFile() {
    if (descriptor >= 0) ::close(descriptor);
    if (descriptor >= 0 && !kept) ::unlink(path.c_str());
  }
};

int write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

// After the rename: the directory entry itself reaches the disk. Some file systems cannot sync a
// directory; the file is whole then all the same.
void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes, IfExists if_exists) {
  std::error_code failure;
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  if (if_exists == IfExists::kRefuse && std::filesystem::exists(path, failure)) {
    return Error{ErrorCode::kOutputExists, "the output exists already; --force replaces it",
                 path.string(), ""};
  }
  std::filesystem::create_directories(directory, failure);
  UnfinishedFile file;
  file.path = path.string() + "." + std::to_string(::getpid()) + ".tmp";
  file.descriptor = ::open(file.path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.descriptor < 0) return write_error(path, "cannot create the file", errno);
  if (const int number = write_all(file.descriptor, bytes); number != 0) {
    return write_error(path, "cannot write", number);
  }
  if (::fsync(file.descriptor) != 0) return write_error(path, "cannot sync", errno);
  if (::rename(file.path.c_str(), path.c_str()) != 0) {
    return write_error(path, "cannot rename into place", errno);
  }
  file.kept = true;
  sync_directory(directory);
  return {};
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text,
                                   IfExists if_exists) {
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), if_exists);
}

Result<FileContent> read_file_content(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    const ErrorCode code = errno == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kCannotOpen;
    return Error{code, std::string("cannot open: ") + std::strerror(errno), path.string(), ""};
  }
  const UnfinishedFile closer{path, descriptor, /*kept=*/true};
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    return Error{ErrorCode::kCannotRead, "not a regular file", path.string(), ""};
  }
  FileContent content(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < content.bytes().size()) {
    const ssize_t count = ::read(descriptor, content.data() + done, content.bytes().size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return Error{ErrorCode::kCannotRead, count < 0 ? std::strerror(errno) : "the file shrank",
                   path.string(), "byte " + std::to_string(done)};
    }
    done += static_cast<std::size_t>(count);
  }
  return content;
}

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(path));
  return std::vector<std::byte>(content.bytes().begin(), content.bytes().end());
}

Result<std::string> read_text_file(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace sightline
