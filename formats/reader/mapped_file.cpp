#include "formats/reader/mapped_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "formats/base/files/regular_file.h"

namespace sightline {
namespace {

Error failure(int number, const std::string& path) {
  return {number == ENOMEM ? ErrorCode::kOutOfMemory : ErrorCode::kCannotRead,
          std::generic_category().message(number), path};
}

Result<void> read_into(std::span<std::byte> memory, const RegularFile& file,
                       const std::string& path) {
  while (!memory.empty()) {
    const ssize_t count = ::read(file.descriptor.number(), memory.data(), memory.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(errno, path);
    if (count == 0) {
      return Error{ErrorCode::kCannotRead, "the file became shorter while it was read", path};
    }
    memory = memory.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

}  // namespace

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<MappedFile> MappedFile::open(const std::string& path, Use use) {
  SIGHTLINE_ASSIGN(const RegularFile file, open_regular_file(path));
  if (file.size == 0) return MappedFile();
  const bool is_copied = use == Use::kCopied;
  const int access = is_copied ? PROT_READ | PROT_WRITE : PROT_READ;
  const int kind = is_copied ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_PRIVATE;
  void* data =
      ::mmap(nullptr, file.size, access, kind, is_copied ? -1 : file.descriptor.number(), 0);
  if (data == MAP_FAILED) return failure(errno, path);
  const std::span<std::byte> memory(static_cast<std::byte*>(data), file.size);
  MappedFile mapped{std::span<const std::byte>(memory)};
  // Advice only: where it is not taken, more is read than is needed.
  if (use == Use::kHereAndThere) (void)::madvise(data, file.size, MADV_RANDOM);
  if (!is_copied) return mapped;
  SIGHTLINE_TRY(read_into(memory, file, path));
  (void)::mprotect(data, file.size, PROT_READ);
  return mapped;
}

}  // namespace sightline
