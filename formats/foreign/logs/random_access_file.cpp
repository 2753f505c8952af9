#include "formats/foreign/logs/random_access_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace sightline {

Result<RandomAccessFile> RandomAccessFile::open(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RegularFile file, open_regular_file(path.string()));
  return RandomAccessFile(path, std::move(file));
}

Result<void> RandomAccessFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count =
        ::pread(file_.descriptor.number(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return error_at(
          offset,
          count < 0 ? std::strerror(errno) : "the file has become shorter while it was read",
          ErrorCode::kCannotRead);
    }
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

}  // namespace sightline
