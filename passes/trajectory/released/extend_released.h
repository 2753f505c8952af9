#pragma once

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"
#include "passes/trajectory/estimate_trajectory.h"

namespace sightline {

// The drives of `drive` that were shipped in a map, without those named after them. Errors:
// mismatched-inputs (no drive is released, or a part of one; place: the drive), bad-value (a
// released drive is named after one that is not).
Result<Drive> released_drive(PassContext& ctx, const NoOptions& options, const Drive& drive,
                             const ReleasedPoses& released);
inline constexpr Pass kReleasedDrive =
    Pass{"released-drive", 1, "released-drive", "Drives of an earlier map", &released_drive}.in(
        Stage::kGraph);

// Their poses as they were released, in the frame of `drive`. Errors: those of released_drive().
Result<Trajectory> released_trajectory(PassContext& ctx, const NoOptions& options,
                                       const Drive& drive, const ReleasedPoses& released);
inline constexpr Pass kReleasedTrajectory =
    Pass{"released-trajectory", 1, "released-trajectory", "Trajectories of these drives",
         &released_trajectory}
        .in(Stage::kGraph);

// Where the vehicle was at each scan of several drives, some of which were shipped in a map:
// released poses stay to the bit, in their frame. The other drives, named after the released ones,
// are estimated by themselves (estimate_trajectory), then aligned to the released ones, which are
// fixed. Pieces that meet nothing are separated (join_pieces).
// `straight`: undistort_scans() of released_drive() and released_trajectory(). Errors: those of
// released_drive(), mismatched-inputs (`straight` is not of the released drives), and those of
// estimate_trajectory.
Result<Trajectory> extend_released(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                   const Drive& drive, const Drive& straight,
                                   const ReleasedPoses& released);
inline constexpr Pass kExtendReleased = variant_of(kEstimateTrajectory, &extend_released);

// The poses of a map, to be shipped with it. Error: invalid-artifact (scans without an identity).
Result<ReleasedPoses> release_poses(PassContext& ctx, const NoOptions& options, const Drive& drive,
                                    const Trajectory& trajectory);
inline constexpr Pass kReleasePoses =
    Pass{"release-poses", 1, "released-poses", "Poses to keep in the next map", &release_poses}.in(
        Stage::kTiles);

}  // namespace sightline
