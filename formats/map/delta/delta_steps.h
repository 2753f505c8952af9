#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/files/regular_file.h"
#include "formats/base/result.h"
#include "formats/map/delta/delta_format.h"

// Follows a delta step by step.

namespace sightline {

// A regular file that is read piece by piece; not mapped, so that memory does not grow with it.
class PieceReader {
 public:
  // Errors: file-not-found, cannot-open, cannot-read (a folder, a pipe, a device).
  static Result<PieceReader> open(const std::filesystem::path& path);

  [[nodiscard]] std::uint64_t size() const { return file_.size; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  // Errors: cannot-read; truncated-file where the file has become shorter.
  [[nodiscard]] Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t size) const;

 private:
  PieceReader(std::filesystem::path path, RegularFile file)
      : path_(std::move(path)), file_(std::move(file)) {}
  std::filesystem::path path_;
  RegularFile file_;
};

struct OpenedDelta {
  PieceReader file;
  DeltaHeader header;
  std::vector<DeltaStep> steps;
};

// Reads and checks all but the payloads, as schemas/delta_format.md demands before a byte is
// written.
Result<OpenedDelta> open_delta(const std::filesystem::path& path);

// The bytes of the result that a step makes of the base, checked; its payload begins at a byte of
// the delta. Memory: a few times kLargestStep.
// Errors: checksum-mismatch, bad-delta, digest-mismatch, truncated-file, cannot-read.
Result<std::vector<std::byte>> make_step(const OpenedDelta& delta, const PieceReader& base,
                                         const DeltaStep& step, std::uint64_t payload_offset);

// How the payloads of a delta are packed: zstd, where it pays with bytes of the base as prefix.

inline constexpr std::uint32_t kRepackLevel = 15;  // as pack() packs the blocks of a map

// The version of zstd that this program runs with, as 10000 major + 100 minor + patch.
std::uint32_t zstd_version();

// One frame that states its content size; the same bytes for the same version of zstd.
std::vector<std::byte> pack_delta(std::span<const std::byte> raw,
                                  std::span<const std::byte> prefix);

// Exactly `size` bytes. Memory: those, and a window of at most 8 MiB. Error: bad-delta.
Result<std::vector<std::byte>> unpack_delta(std::span<const std::byte> packed,
                                            std::span<const std::byte> prefix, std::uint64_t size);

// What a zstd frame says that it holds; 0 where it is none or does not say.
std::uint64_t content_size(std::span<const std::byte> packed);

// The frame that a map's block of these raw bytes is, where it is packed by the same version.
std::vector<std::byte> pack_anew(std::span<const std::byte> raw, std::uint32_t level);

}  // namespace sightline
