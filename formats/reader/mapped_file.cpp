#include "formats/reader/mapped_file.h"

#include <sys/mman.h>

#include <cerrno>
#include <system_error>

#include "formats/base/files/regular_file.h"

namespace sightline {
namespace {

Result<std::span<const std::byte>> map_file(const RegularFile& file, const std::string& path) {
  if (file.size == 0) return std::span<const std::byte>();
  void* data = ::mmap(nullptr, file.size, PROT_READ, MAP_PRIVATE, file.descriptor.number(), 0);
  if (data != MAP_FAILED) return std::span(static_cast<const std::byte*>(data), file.size);
  const int number = errno;
  return Error{number == ENOMEM ? ErrorCode::kOutOfMemory : ErrorCode::kCannotRead,
               std::generic_category().message(number), path};
}

}  // namespace

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<MappedFile> MappedFile::open(const std::string& path, Use use) {
  SIGHTLINE_ASSIGN(const RegularFile file, open_regular_file(path));
  const Result<std::span<const std::byte>> bytes = map_file(file, path);
  if (!bytes) return bytes.error();
  if (use == Use::kHereAndThere && !bytes->empty()) {
    // Advice only: where it is not taken, more is read than is needed.
    (void)::madvise(const_cast<std::byte*>(bytes->data()), bytes->size(), MADV_RANDOM);
  }
  return MappedFile(*bytes);
}

}  // namespace sightline
