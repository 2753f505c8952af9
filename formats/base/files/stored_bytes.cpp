#include "formats/base/files/stored_bytes.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;

fs::path folder_for_temporary_files() {
  std::error_code failure;
  const fs::path folder = fs::temp_directory_path(failure);
  return failure ? fs::path("/tmp") : folder;
}

// Some file systems have no files without a name: there it loses its name at once.
Result<Descriptor> file_without_name(const fs::path& folder) {
  Descriptor unnamed(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (unnamed.number() >= 0) return unnamed;
  std::string path = folder / "sightline-XXXXXX";
  Descriptor named(::mkostemp(path.data(), O_CLOEXEC));
  if (named.number() < 0) return write_failure(folder, "cannot create a temporary file", errno);
  ::unlink(path.c_str());
  return named;
}

}  // namespace

StoredBytes::StoredBytes(std::vector<std::byte> bytes)
    : memory_(std::make_shared<const std::vector<std::byte>>(std::move(bytes))),
      size_(memory_->size()) {}

StoredBytes::StoredBytes(Descriptor file, std::uint64_t size)
    : file_(std::make_shared<const Descriptor>(std::move(file))), size_(size) {}

StoredBytes StoredBytes::part(std::uint64_t offset, std::uint64_t size) const {
  SIGHTLINE_CHECK(offset <= size_ && size <= size_ - offset);
  StoredBytes part = *this;
  part.begin_ += offset;
  part.size_ = size;
  return part;
}

Result<void> StoredBytes::read(std::uint64_t offset, std::span<std::byte> into) const {
  SIGHTLINE_CHECK(offset <= size_ && into.size() <= size_ - offset);
  if (memory_) {
    std::copy_n(memory_->begin() + static_cast<std::ptrdiff_t>(begin_ + offset), into.size(),
                into.begin());
    return {};
  }
  std::size_t done = 0;
  while (done < into.size()) {
    const std::uint64_t at = begin_ + offset + done;
    const ssize_t count =
        ::pread(file_->number(), into.data() + done, into.size() - done, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return Error{ErrorCode::kCannotRead,
                   count < 0 ? std::strerror(errno) : "the file became shorter while it was read",
                   "", concat("byte ", at)};
    }
    done += static_cast<std::size_t>(count);
  }
  return {};
}

Result<std::vector<std::byte>> StoredBytes::read(std::uint64_t offset, std::size_t size) const {
  std::vector<std::byte> bytes(size);
  SIGHTLINE_TRY(read(offset, std::span(bytes)));
  return bytes;
}

Result<void> StoredBytes::visit(const ByteSink& sink) const {
  std::vector<std::byte> piece(std::min(kPiece, size_));
  for (std::uint64_t offset = 0; offset < size_; offset += kPiece) {
    const auto filled = std::span(piece).first(std::min(kPiece, size_ - offset));
    SIGHTLINE_TRY(read(offset, filled));
    SIGHTLINE_TRY(sink(filled));
  }
  return {};
}

Result<void> GrowingBytes::append(std::span<const std::byte> bytes) {
  if (!is_in_file() && bytes.size() <= most_in_memory_ - std::min(most_in_memory_, size_)) {
    memory_.insert(memory_.end(), bytes.begin(), bytes.end());
    size_ += bytes.size();
    return {};
  }
  const fs::path folder = folder_for_temporary_files();
  const auto write = [&](std::span<const std::byte> piece) -> Result<void> {
    const int number = write_all(file_, piece);
    if (number != 0) return write_failure(folder, "cannot write a temporary file", number);
    return {};
  };
  if (!is_in_file()) {
    SIGHTLINE_ASSIGN(file_, file_without_name(folder));
    SIGHTLINE_TRY(write(memory_));
    std::vector<std::byte>().swap(memory_);
  }
  SIGHTLINE_TRY(write(bytes));
  size_ += bytes.size();
  return {};
}

Result<void> GrowingBytes::replace(std::uint64_t offset, std::span<const std::byte> bytes) {
  SIGHTLINE_CHECK(offset <= size_ && bytes.size() <= size_ - offset);
  if (!is_in_file()) {
    std::ranges::copy(bytes, memory_.begin() + static_cast<std::ptrdiff_t>(offset));
    return {};
  }
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::pwrite(file_.number(), bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return write_failure(folder_for_temporary_files(), "cannot write a temporary file", errno);
    }
    done += static_cast<std::size_t>(count);
  }
  return {};
}

StoredBytes GrowingBytes::take() {
  if (is_in_file()) return {std::move(file_), std::exchange(size_, 0)};
  size_ = 0;
  return StoredBytes(std::move(memory_));
}

}  // namespace sightline
