#pragma once

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
// by their stamps. A scan that meets too little of that map is searched for at all headings and
// farther around. Where no place or several fit, where time jumps and where a part of the drive
// begins, the scan begins a new piece, with a map of its own, at the pose of the last scan.
// `given` poses place the first scan and are used where matching fails. Parts of a drive, and
// stretches with given poses, are followed in parallel, each with a local map of its own
// (scan_runs.h). Overlaps are left out where poses are given for all scans (overlaps_along).
// Errors: drive-too-short, and those of reading a scan.
Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const GivenPoses& given);

}  // namespace sightline
