#include "formats/reader/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace sightline {
namespace {

Error failure(ErrorCode code, const std::string& path, int error) {
  return {code, std::generic_category().message(error), path, ""};
}

Result<std::span<const std::byte>> map_descriptor(int descriptor, const std::string& path) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return failure(ErrorCode::kCannotRead, path, errno);
  if (!S_ISREG(status.st_mode)) {
    return Error{ErrorCode::kCannotRead, "this is no regular file", path, ""};
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return std::span<const std::byte>();
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (data == MAP_FAILED) return failure(ErrorCode::kCannotRead, path, errno);
  return std::span(static_cast<const std::byte*>(data), size);
}

}  // namespace

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<MappedFile> MappedFile::open(const std::string& path, Use use) {
  // Without O_NONBLOCK a pipe would wait for its writer.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    const int error = errno;
    return failure(error == ENOENT ? ErrorCode::kFileNotFound : ErrorCode::kCannotOpen, path,
                   error);
  }
  const Result<std::span<const std::byte>> bytes = map_descriptor(descriptor, path);
  ::close(descriptor);
  if (!bytes) return bytes.error();
  if (use == Use::kHereAndThere && !bytes->empty()) {
    // Advice only: where it is not taken, more is read than is needed.
    (void)::madvise(const_cast<std::byte*>(bytes->data()), bytes->size(), MADV_RANDOM);
  }
  return MappedFile(*bytes);
}

}  // namespace sightline
