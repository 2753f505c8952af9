#include "formats/base/files/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace sightline {

Descriptor::~Descriptor() { close(); }

int Descriptor::close() {
  const int number = std::exchange(number_, -1);
  return number >= 0 && ::close(number) != 0 ? errno : 0;
}

Result<RegularFile> open_regular_file(const std::string& path) {
  RegularFile file;
  file.descriptor = Descriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (file.descriptor.number() < 0) {
    const int number = errno;
    const ErrorCode code = number == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kCannotOpen;
    return Error{code, std::string("cannot open: ") + std::strerror(number), path};
  }
  struct stat status {};
  if (::fstat(file.descriptor.number(), &status) != 0) {
    return Error{ErrorCode::kCannotRead, std::strerror(errno), path};
  }
  if (!S_ISREG(status.st_mode))
    return Error{ErrorCode::kCannotRead, "not a regular file (a folder, pipe or device)", path};
  file.size = static_cast<std::uint64_t>(status.st_size);
  return file;
}

Result<std::string> read_beginning(const std::string& path, std::size_t most_bytes) {
  SIGHTLINE_ASSIGN(const RegularFile file, open_regular_file(path));
  std::string text(most_bytes, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::read(file.descriptor.number(), text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return Error{ErrorCode::kCannotRead, std::strerror(errno), path};
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  text.resize(done);
  return text;
}

}  // namespace sightline
