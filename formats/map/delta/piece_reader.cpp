#include "formats/map/delta/piece_reader.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace sightline {
namespace {

Error failure(ErrorCode code, const std::filesystem::path& path, const char* what, int number) {
  return {code, std::string(what) + ": " + std::strerror(number), path.string()};
}

}  // namespace

Result<PieceReader> PieceReader::open(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(RegularFile file, open_regular_file(path.string()));
  return PieceReader(path, std::move(file));
}

Result<std::vector<std::byte>> PieceReader::read(std::uint64_t offset, std::uint64_t size) const {
  std::vector<std::byte> bytes(size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pread(file_.descriptor.number(), bytes.data() + done,
                                  bytes.size() - done, static_cast<off_t>(offset + done));
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
