#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/estimate_options.h"

// What becomes of poses that came with a drive; part of estimate-trajectory.

namespace sightline {

// A trajectory by odometry and by the given poses (T_map_lidar) that are there.
using TrajectorySolver = std::function<Result<Trajectory>(
    const std::vector<std::optional<Pose>>& given, const Odometry& odometry)>;

// Given poses as they are. Error: no-poses, naming the first scan without one.
Result<Trajectory> trajectory_as_given(const Drive& drive);

// Given poses as they are where the scans have nothing against them. Jumps are refused, or left out
// and the other poses refined (repair); on other disagreements it is as bad_poses says. In mode
// auto they are refined where that makes scans lie on each other more sharply, with a warning.
// Errors: no-poses, mismatched-inputs (refused), those of run_odometry and of `solve`.
Result<Trajectory> checked_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, const TrajectorySolver& solve);

// Given poses, of some scans or all, refined; jumps are refused or left out as above (mode refine
// leaves them out too). Errors: the same.
Result<Trajectory> refined_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, const TrajectorySolver& solve);

}  // namespace sightline
