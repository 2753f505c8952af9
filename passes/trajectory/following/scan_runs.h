#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"

// A drive in runs of scans that are followed side by side; part of estimate-trajectory.

namespace sightline {

// Followed from `first` on; what comes before `begin` is there for the local map alone.
struct ScanRun {
  std::size_t first = 0;
  std::size_t begin = 0;
  std::size_t end = 0;  // one behind the last
};

// Ascending, without a gap from `begin` to `begin`. A run begins with each part of the drive, which
// nothing before it leads to, and, where `given` (T_map_lidar, one a scan) leads from scan to scan,
// from ten `local_map_m` of the way on, an even number of times: about every five. Of a given way
// that moves nowhere there is one run.
std::vector<ScanRun> scan_runs(const Drive& drive, const std::vector<std::optional<Pose>>& given,
                               double local_map_m);

// What was found of each run (one or more), from its `first` scan on and in a frame of its own, as
// that of one drive in the frame of the first run: each is laid where the one before it ended. What
// begins with a part begins a piece.
Odometry joined_runs(std::span<const ScanRun> runs, const std::vector<Odometry>& followed);

}  // namespace sightline
