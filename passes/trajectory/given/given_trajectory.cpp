#include "passes/trajectory/given/given_trajectory.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include "passes/trajectory/given/judge_given.h"
#include "passes/trajectory/given/parts_apart.h"

namespace sightline {
namespace {

// T_map_lidar of each scan as given, none where it is not there.
std::vector<std::optional<Pose>> given_poses(const Drive& drive) {
  std::vector<std::optional<Pose>> given(drive.scans.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!drive.scans[i].T_world_vehicle) continue;
    given[i] = rebase(*drive.scans[i].T_world_vehicle, MapFrame{}, drive.frame) *
               drive.sensor.T_vehicle_lidar;
  }
  return given;
}

// Beyond three sigma of what given poses are taken to be off, a pose is wrong and not inaccurate.
JumpLimits limits_of(const EstimateTrajectoryOptions& options) {
  return {3.0 * options.prior_sigma_m, 3.0 * options.prior_sigma_deg * std::numbers::pi / 180.0};
}

// A drive with given poses, what is wanted of it, and how to get there.
struct Task {
  PassContext& ctx;
  const EstimateTrajectoryOptions& options;
  const Drive& drive;
  const TrajectorySolver& solve;
};

// Without the poses that the scans contradict.
Result<Trajectory> repaired(const Task& task, const std::vector<std::optional<Pose>>& given,
                            const std::vector<PoseJump>& jumps) {
  const EstimateTrajectoryOptions& options = task.options;
  const bool may_repair =
      options.bad_poses == BadPoses::kRepair ||
      (options.mode == PoseMode::kRefine && options.bad_poses == BadPoses::kWarn);
  if (!may_repair) return refused_jumps(jumps, task.drive);
  task.ctx.warn(jumps_text(jumps, task.drive) + ". These are left out, the others refined");
  const std::vector<std::optional<Pose>> believed = without_jumps(given, jumps);
  // Anew: where a scan did not match, odometry went on with its given pose.
  SIGHTLINE_ASSIGN(const Odometry odometry,
                   run_odometry(task.ctx, options.local_map_m, task.drive, believed));
  return task.solve(believed, odometry);
}

// Refined where the scans then lie on each other more sharply, and says so; else none.
Result<std::optional<Trajectory>> sharpened(const Task& task,
                                            const std::vector<std::optional<Pose>>& given,
                                            const Odometry& odometry,
                                            const std::vector<PoseDisagreement>& disagreements) {
  const std::optional<Trajectory> none;
  const std::vector<WayStretch> stretches = stretches_of(given, odometry, disagreements);
  if (std::ranges::none_of(stretches, is_doubtful)) return none;
  SIGHTLINE_ASSIGN(Trajectory refined, task.solve(given, odometry));
  std::vector<Pose> T_map_lidar;
  for (const TrajectoryPose& pose : refined.poses) {
    T_map_lidar.push_back(pose.T_map_vehicle * task.drive.sensor.T_vehicle_lidar);
  }
  SIGHTLINE_ASSIGN(const Sharpening sharpening,
                   compare_sharpness(task.ctx, task.drive, stretches, given, T_map_lidar));
  if (!sharpening.is_sharper) return none;
  task.ctx.warn(sharpening_text(sharpening, stretches, task.drive));
  return std::optional<Trajectory>(std::move(refined));
}

}  // namespace

Result<Trajectory> trajectory_as_given(const Drive& drive) {
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  for (const ScanInfo& scan : drive.scans) {
    if (!scan.T_world_vehicle) {
      return Error{ErrorCode::kNoPoses, "the recording gives no pose of this scan", scan.source,
                   "scan " + std::to_string(scan.recording_index)};
    }
    trajectory.poses.push_back({scan.recording_index, scan.stamp_ns,
                                rebase(*scan.T_world_vehicle, MapFrame{}, drive.frame)});
  }
  return trajectory;
}

Result<Trajectory> checked_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, const TrajectorySolver& solve) {
  Result<Trajectory> unchanged = trajectory_as_given(drive);
  if (!unchanged || options.bad_poses == BadPoses::kIgnore || drive.scans.size() < 2) {
    return unchanged;
  }
  const Task task{ctx, options, drive, solve};
  const std::vector<std::optional<Pose>> given = given_poses(drive);
  SIGHTLINE_ASSIGN(const std::vector<PartApart> apart, find_parts_apart(drive, given));
  if (!apart.empty()) {
    if (options.bad_poses == BadPoses::kRepair) {
      return refined_trajectory(ctx, options, drive, solve);
    }
    return Error{ErrorCode::kMismatchedInputs,
                 parts_text(apart, drive) +
                     "; estimate-trajectory.bad_poses=repair joins them by what they see",
                 drive.scans[apart.front().worst].source,
                 "scan " + std::to_string(drive.scans[apart.front().worst].recording_index)};
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  SIGHTLINE_ASSIGN(const GivenVerdict verdict,
                   judge_given(drive, limits_of(options), given, odometry));
  if (!verdict.jumps.empty()) return repaired(task, given, verdict.jumps);
  const std::vector<PoseDisagreement>& found = verdict.disagreements;
  if (!found.empty() && options.bad_poses == BadPoses::kRefuse) {
    return refused_disagreements(found, drive);
  }
  if (!found.empty() && options.bad_poses == BadPoses::kRepair) {
    ctx.warn(disagreements_text(found, drive) + ". They are refined");
    return solve(given, odometry);
  }
  std::optional<Trajectory> refined;
  if (options.mode == PoseMode::kAuto) {
    SIGHTLINE_ASSIGN(refined, sharpened(task, given, odometry, found));
  }
  if (!found.empty()) {
    ctx.warn(disagreements_text(found, drive) +
             (refined
                  ? ""
                  : ". They are used all the same; estimate-trajectory.bad_poses=repair refines "
                    "them"));
  }
  return refined ? Result<Trajectory>(*std::move(refined)) : unchanged;
}

Result<Trajectory> refined_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, const TrajectorySolver& solve) {
  std::vector<std::optional<Pose>> given = given_poses(drive);
  if (options.bad_poses != BadPoses::kIgnore) {
    SIGHTLINE_ASSIGN(const std::vector<PartApart> apart, find_parts_apart(drive, given));
    if (!apart.empty()) {
      ctx.warn(parts_text(apart, drive) + ". Their poses are left out");
      given = without_parts(std::move(given), drive, apart);
    }
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  if (options.bad_poses == BadPoses::kIgnore) return solve(given, odometry);
  SIGHTLINE_ASSIGN(const std::vector<PoseJump> jumps,
                   find_jumps(drive, limits_of(options), given, odometry));
  if (!jumps.empty()) return repaired({ctx, options, drive, solve}, given, jumps);
  return solve(given, odometry);
}

}  // namespace sightline
