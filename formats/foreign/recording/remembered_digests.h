#pragma once

#include <optional>

#include "formats/foreign/recording/digest_memory.h"
#include "formats/foreign/recording/recording.h"

// A file that was not written to since is not read again to know its digest. That it was not
// written to is decided as make and git do: by its place, size, inode, and the times of its last
// change, the second of which cannot be set. A file that is read later is compared with its digest
// all the same.

namespace sightline {

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
