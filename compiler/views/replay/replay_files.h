#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/text/table.h"
#include "passes/replay/replay_drive.h"

// The poses of a replayed drive as files. None contains times of the computation: the same drive,
// map and start give the same bytes.

namespace sightline {

// By the ending: .csv, .mcap, else TUM. A file appears whole or not at all. Errors: those of
// write_file_atomically.
Result<void> write_poses(const std::filesystem::path& file, const std::vector<ListedScan>& scans,
                         const ReplayedDrive& drive, IfExists if_exists);

// A row of each scan; cells of the pose are empty where it was not localized.
Table poses_table(const std::vector<ListedScan>& scans, const ReplayedDrive& drive);

// Of scans that were localized on /sightline/pose and, as one line, on /sightline/path; of every
// scan that was read a status on /diagnostics.
std::vector<std::byte> poses_mcap(const std::vector<ListedScan>& scans, const ReplayedDrive& drive);

}  // namespace sightline
