#pragma once

#include <optional>
#include <span>
#include <vector>

#include "formats/base/hash.h"
#include "formats/foreign/recording/recording.h"

// A file that was not written to since is not read again to know its digest. That it was not
// written to is decided as make and git do: by its place, size, inode, and the times of its last
// change, the second of which cannot be set. A file that is read later is compared with its digest
// all the same.

namespace sightline {

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

}  // namespace sightline
