#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/local/estimate_options.h"

namespace sightline {

// Followed from `first` on; scans before `begin` are only for the local map.
struct ScanRun {
  std::size_t first = 0;
  std::size_t begin = 0;
  std::size_t end = 0;  // one behind the last
};

// Ascending, without a gap from `begin` to `begin`. A run begins with each part of the drive and,
// where `given` leads from scan to scan for ten `local_map_m` of way or more, an even number of
// times: about every five. Poses that do not move give one run.
std::vector<ScanRun> scan_runs(const Drive& drive, const GivenPoses& given, double local_map_m);

// The odometries of all runs (one or more), each from its `first` scan on and in a frame of its
// own, as one in the frame of the first: each begins where the one before it ended. The first scan
// of a part begins a piece.
Odometry joined_runs(std::span<const ScanRun> runs, const std::vector<Odometry>& followed);

}  // namespace sightline
