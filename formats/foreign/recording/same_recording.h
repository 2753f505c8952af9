#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// A file that was not written to since is not read again for its digest, as make and git decide it:
// by its place, size, inode and times of its last change, the second of which cannot be set. A file
// that is read later is compared with its digest all the same.

// Keeps what was read of scan files from one run to the next, under a key that names in which state
// the files were then.
class DigestMemory {
 public:
  virtual ~DigestMemory() = default;
  // Nothing where nothing is known.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> load(const Digest& key) const = 0;
  // What cannot be kept is read again by the next run, so that is not reported.
  virtual void store(const Digest& key, std::span<const std::byte> content) const = 0;
};

// Names the state of all scan files and the columns that were asked for. Nothing where a file
// cannot be asked about, or was changed within the last two seconds: then another change might
// leave the same times. The scans have files of their own.
std::optional<Digest> state_of_files(const Recording& recording);

// Digests, columns and warnings that a memory holds for this state: whether it has them.
bool recall_digests(const DigestMemory& memory, const Digest& state, Recording& recording);

// Keeps them; the warnings are those from `first_warning` on.
void remember_digests(const DigestMemory& memory, const Digest& state, const Recording& recording,
                      std::size_t first_warning);

// Whether two recordings are the same one, whatever their paths, names, poses and sensors are.

// Where the scans of a recording lie, before it is opened.
struct RecordingPlace {
  std::filesystem::path path;  // absolute, links followed, without a slash at its end
  std::string topic;           // of a bag; empty: its only one
  // Of the files with the scans, in the order of the scans; empty where there are none to read.
  std::vector<std::filesystem::path> files;
  std::vector<std::uintmax_t> sizes;

  // Path and topic: equal for two spellings of one path.
  [[nodiscard]] std::string name() const;
};

RecordingPlace place_of(const RecordingOptions& options);

// Whether both are one place or hold equal bytes in the same order. Reads files only as far as all
// sizes agree. Two topics of one bag are different recordings.
bool is_same_recording(const RecordingPlace& a, const RecordingPlace& b);
bool is_same_recording(const RecordingOptions& a, const RecordingOptions& b);

// Names the contents of all scans in their order: equal for recordings that hold the same scans,
// also in files of another name or in a bag that was packed differently.
Digest scans_digest(const Recording& recording);

}  // namespace sightline
