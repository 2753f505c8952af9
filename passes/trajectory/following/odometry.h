#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/local/estimate_options.h"
#include "passes/trajectory/local/local_match.h"

// Odometry by matching scans; part of estimate-trajectory. Poses are the sensor's: T_map_lidar.

namespace sightline {

// Whether every scan has a given pose.
bool lead_to_all(const GivenPoses& given);

// Moves an odometry so that the first scan with a given pose is at that pose: the pose graph then
// moves poses little.
void start_at_given(const GivenPoses& given, Odometry& odometry);

// Matches scan after scan to a map of the last `local_map_m` of way, from where even motion leads
// by their stamps, or by a search farther around ("Trajectories" in schemas/definitions.md). Where
// no place or several fit, where time jumps and where a part of the drive begins, the scan begins a
// new piece, with a map of its own, at the pose of the last scan. `given` poses place the first
// scan and are used where matching fails. Runs (scan_runs) are followed in parallel. Overlaps are
// left out where poses are given for all scans (overlaps_along).
// Errors: drive-too-short, and those of reading a scan.
Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const GivenPoses& given);

// Odometry::overlap of every scan, for odometry with given poses of all scans, which leaves it out.
// Shared by ctx.threads. Errors: those of reading a scan.
Result<std::vector<std::optional<double>>> overlaps_along(const PassContext& ctx,
                                                          const Drive& drive, double local_map_m,
                                                          const Odometry& odometry);

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
