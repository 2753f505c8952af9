#include "formats/map/delta/piece_reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace sightline {
namespace {

Error failure(ErrorCode code, const std::filesystem::path& path, const char* what, int number) {
  return {code, std::string(what) + ": " + std::strerror(number), path.string(), ""};
}

}  // namespace

PieceReader::PieceReader(PieceReader&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

PieceReader::~PieceReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<PieceReader> PieceReader::open(const std::filesystem::path& path) {
  // Without waiting for somebody to write into a pipe.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    const ErrorCode code = errno == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kCannotOpen;
    return failure(code, path, "cannot open", errno);
  }
  PieceReader reader(path, descriptor);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    return Error{ErrorCode::kCannotRead, "not a regular file", path.string(), ""};
  }
  reader.size_ = static_cast<std::uint64_t>(status.st_size);
  return reader;
}

Result<std::vector<std::byte>> PieceReader::read(std::uint64_t offset, std::uint64_t size) const {
  std::vector<std::byte> bytes(size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(descriptor_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(ErrorCode::kCannotRead, path_, "cannot read", errno);
    if (count == 0) {
      return Error{ErrorCode::kTruncatedFile, "the file became shorter", path_.string(),
                   "byte " + std::to_string(offset + done)};
    }
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace sightline
