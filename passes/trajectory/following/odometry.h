#pragma once

#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/local/local_match.h"

// The parts of estimate-trajectory that match scans. Poses here are the sensor's: T_map_lidar.

namespace sightline {

// Whether every scan has a given pose.
bool lead_to_all(const std::vector<std::optional<Pose>>& given);

// Scan after scan against a map of the last `local_map_m` of the way, from where even motion since
// the scans before would take it, by their stamps. Where too little of a scan meets that map it is
// looked for at all headings and farther around; where that finds no place, or several alike, and
// where time jumps or a part of the drive begins, the scan begins a new piece with a map of its
// own, where the last scan was.
// `given`, one a scan, are T_map_lidar where a recording has them: they put the first scan in its
// place, and carry on where matching fails. Parts of a drive, and stretches that given poses lead
// to, are followed side by side (scan_runs.h), each with a local map of its own. Where
// they lead to all scans, overlaps are left out (overlaps_along). Errors:
// drive-too-short, and what reading a scan says.
Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given);

}  // namespace sightline
