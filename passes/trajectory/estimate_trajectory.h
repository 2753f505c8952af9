#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"
#include "passes/trajectory/local/estimate_options.h"

namespace sightline {

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options);

// Where the vehicle was at each scan of the drive, in the drive's frame ("Trajectories" in
// schemas/definitions.md; the steps are those of estimate_trajectory.cpp). Estimated: in the first
// scan's vehicle frame; refined: where given poses put it. A warning where loops contradict the
// poses, and where drives differ in scale. Errors: no-poses (mode given or refine without),
// mismatched-inputs (poses are refused; place: the worst scan), trajectory-lost (matching fails and
// no given pose helps; place: the scan), drive-too-short (fewer than two scans to match), and those
// of reading a scan.
Result<Trajectory> estimate_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                       const Drive& drive);
inline constexpr Pass kEstimateTrajectory =
    Pass{"estimate-trajectory", 32, "trajectory", "Trajectory of the vehicle", &estimate_trajectory}
        .in(Stage::kGraph)
        .with({.million_points_s = 0.3, .without_poses_s = 0.9});

}  // namespace sightline
