#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/foreign/recording/recording.h"

// Whether two recordings are the same one, whatever their paths, names, poses and sensors are.

namespace sightline {

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
