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
// trajectory's frame, without what moved. A voxel moved when its log odds by the sensor model of
// OctoMap (Hornung et al., Autonomous Robots 34, 2013), hits and misses counted once a scan, are
// below even. Edges of what stands stay, weakly seen parts of what moved are removed with it,
// ground (and level surfaces up to 0.5 m above it) stays unless rays pass below it, and what is
// over 2 m above the ground is removed only with something at every height below it, never above
// 4.5 m. Memory does not grow with the drive: the result refers to the drive's scans. Errors:
// mismatched-inputs (the trajectory is not of this drive), drive-too-short (no scan chosen),
// empty-map (no return within range), and those of reading a scan.
Result<SurfacePoints> remove_moving(PassContext& ctx, const RemoveMovingOptions& options,
                                    const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kRemoveMoving =
    Pass{"remove-moving", 6, "points", "Removing moving objects", &remove_moving}
        .in(Stage::kTiles)
        .with({.million_points_s = 0.75});

}  // namespace sightline
