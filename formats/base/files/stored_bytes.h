#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"

// What is too large for memory lies in a file and is read piece by piece. Nothing is mapped: a
// mapped page counts as memory of the process, and a file that shrinks would end it.

namespace sightline {

// Bytes that do not change, in memory or in an open file. Copies share them. Safe from several
// threads.
class StoredBytes {
 public:
  StoredBytes() = default;  // none
  explicit StoredBytes(std::vector<std::byte> bytes);
  // The first `size` bytes of a file that stays as it is.
  StoredBytes(Descriptor file, std::uint64_t size);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  // A part of them; within what there is.
  [[nodiscard]] StoredBytes part(std::uint64_t offset, std::uint64_t size) const;
  // Fills `into` with the bytes from `offset` on; within what there is. Error: cannot-read.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> into) const;
  [[nodiscard]] Result<std::vector<std::byte>> read(std::uint64_t offset, std::size_t size) const;
  // Hands over all, a mebibyte at a time. Errors: cannot-read, those of the sink.
  [[nodiscard]] Result<void> visit(const ByteSink& sink) const;

 private:
  std::shared_ptr<const std::vector<std::byte>> memory_;
  std::shared_ptr<const Descriptor> file_;
  std::uint64_t begin_ = 0;
  std::uint64_t size_ = 0;
};

// Bytes that are still written: few in memory, more in a file without a name in the folder for
// temporary files (TMPDIR), which is gone with the process.
class GrowingBytes {
 public:
  static constexpr std::size_t kMostInMemory = std::size_t{64} << 20;
  explicit GrowingBytes(std::size_t most_in_memory = kMostInMemory)
      : most_in_memory_(most_in_memory) {}

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] bool is_in_file() const { return file_.number() >= 0; }
  // Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);
  // Puts bytes in place of others; within what there is. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> replace(std::uint64_t offset, std::span<const std::byte> bytes);
  // After the last append().
  [[nodiscard]] StoredBytes take();

 private:
  std::size_t most_in_memory_;
  std::vector<std::byte> memory_;
  Descriptor file_;
  std::uint64_t size_ = 0;
};

}  // namespace sightline
