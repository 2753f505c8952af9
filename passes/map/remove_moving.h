#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass.h"

namespace sightline {

struct RemoveMovingOptions {
  bool enabled = true;          // false: every return within the sensor's range is kept
  double voxel_m = 0.2;         // edge of the voxels that stand or move as a whole
  double carve_range_m = 60.0;  // a ray is not used farther from the sensor than this
  ScanSelection scans = ScanSelection::kAll;  // all, even, odd
};
std::vector<OptionField> option_fields(RemoveMovingOptions& options);

// The returns of the chosen scans within the sensor's minimum and maximum range, in the
// trajectory's frame, without what moved. A voxel moved when other scans look through its points
// more often than its own returns can answer for, by the sensor model of OctoMap (Hornung et al.,
// Autonomous Robots 34, 2013): log odds of hits and misses, each counted once a scan, below even.
// Edges of what stands stay, weakly seen parts of what moved go with it, ground stays unless rays
// pass below it (pavements and verges too, level surfaces up to 0.5 m above it), and what is over
// 2 m above the ground goes only with something at every height below it that moved, never above
// 4.5 m. Works tile by tile and scan by scan: memory does not grow with the
// drive, and the result refers to the drive's scans instead of holding them. Errors:
// mismatched-inputs (the trajectory is not of this drive), drive-too-short (no scan chosen),
// empty-map (no return within range), and what reading a scan says.
Result<SurfacePoints> remove_moving(PassContext& ctx, const RemoveMovingOptions& options,
                                    const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kRemoveMoving =
    Pass{"remove-moving", 6, "points", "What moved leaves the map", &remove_moving}
        .in(Stage::kTiles)
        .with({.million_points_s = 0.6});

}  // namespace sightline
