#include "passes/trajectory/estimate_given.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include "passes/pass/quiet.h"
#include "passes/trajectory/given/judge_given.h"
#include "passes/trajectory/given/misplaced_parts.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/local/stretch_of_drive.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

GivenPoses given_poses(const Drive& drive) {
  GivenPoses given(drive.scans.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!drive.scans[i].T_world_vehicle) continue;
    given[i] = rebase(*drive.scans[i].T_world_vehicle, MapFrame{}, drive.frame) *
               drive.sensor.T_vehicle_lidar;
  }
  return given;
}

// Beyond three standard deviations of given poses, a pose is wrong and not inaccurate.
JumpLimits limits_of(const EstimateTrajectoryOptions& options) {
  return {3.0 * options.prior_sigma_m, 3.0 * options.prior_sigma_deg * std::numbers::pi / 180.0};
}

// Without the poses that the scans contradict.
Result<Estimate> repaired(const EstimateTask& task, const GivenPoses& given,
                          const std::vector<PoseJump>& jumps, const SolvePoses& solve) {
  const EstimateTrajectoryOptions& options = task.options;
  const bool may_repair =
      options.bad_poses == BadPoses::kRepair ||
      (options.mode == PoseMode::kRefine && options.bad_poses == BadPoses::kWarn);
  if (!may_repair) return refused_jumps(jumps, task.drive);
  task.ctx.warn(jumps_text(jumps, task.drive) + ". These are left out, the others refined");
  const GivenPoses used = without_jumps(given, jumps);
  // Anew: where a scan did not match, odometry continued from its given pose.
  SIGHTLINE_ASSIGN(const Odometry odometry,
                   run_odometry(task.ctx, options.local_map_m, task.drive, used));
  return solve(used, odometry);
}

// Refined, with a warning, where the scans then fit each other more sharply; else none.
Result<std::optional<Estimate>> sharpened(const EstimateTask& task, const GivenPoses& given,
                                          const Odometry& odometry,
                                          const std::vector<PoseDisagreement>& disagreements,
                                          const SolvePoses& solve) {
  const std::optional<Estimate> none;
  const std::vector<WayStretch> stretches = stretches_of(given, odometry, disagreements);
  if (std::ranges::none_of(stretches, is_doubtful)) return none;
  SIGHTLINE_ASSIGN(Estimate refined, solve(given, odometry));
  SIGHTLINE_ASSIGN(const Sharpening sharpening,
                   compare_sharpness(task.ctx, task.drive, stretches, given,
                                     sensor_poses(task.drive, refined.trajectory)));
  if (!sharpening.is_sharper) return none;
  task.ctx.warn(sharpening_text(sharpening, stretches, task.drive));
  return std::optional<Estimate>(std::move(refined));
}

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

Error refused_parts(const std::vector<MisplacedPart>& parts, const Drive& drive) {
  const ScanInfo& worst = drive.scans[parts.front().worst];
  return {ErrorCode::kMismatchedInputs,
          parts_text(parts, drive) +
              "; estimate-trajectory.bad_poses=repair joins them by what they see",
          worst.source, "scan " + std::to_string(worst.recording_index)};
}

// The given poses, or refined ones, by where the given ones disagree with odometry.
Result<Estimate> decide(const EstimateTask& task, const GivenPoses& given, const Odometry& odometry,
                        const std::vector<PoseDisagreement>& disagreements,
                        const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  const bool disagrees = !disagreements.empty();
  if (disagrees && options.bad_poses == BadPoses::kRefuse) {
    return refused_disagreements(disagreements, drive);
  }
  if (disagrees && options.bad_poses == BadPoses::kRepair) {
    ctx.warn(disagreements_text(disagreements, drive) + ". They are refined");
    return solve(given, odometry);
  }
  std::optional<Estimate> refined;
  if (options.mode == PoseMode::kAuto) {
    SIGHTLINE_ASSIGN(refined, sharpened(task, given, odometry, disagreements, solve));
  }
  if (disagrees) {
    ctx.warn(disagreements_text(disagreements, drive) +
             (refined
                  ? ""
                  : ". They are used all the same; estimate-trajectory.bad_poses=repair refines "
                    "them"));
  }
  if (refined) return *std::move(refined);
  SIGHTLINE_ASSIGN(Trajectory unchanged, trajectory_as_given(drive));
  return Estimate{std::move(unchanged), {}};
}

}  // namespace

Result<Estimate> check_given(const EstimateTask& task, const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  SIGHTLINE_ASSIGN(Trajectory unchanged, trajectory_as_given(drive));
  if (options.bad_poses == BadPoses::kIgnore || drive.scans.size() < 2) {
    return Estimate{std::move(unchanged), {}};
  }
  const GivenPoses given = given_poses(drive);
  SIGHTLINE_ASSIGN(const std::vector<MisplacedPart> misplaced, find_misplaced_parts(drive, given));
  if (!misplaced.empty()) {
    if (options.bad_poses == BadPoses::kRepair) return refine_given(task, solve);
    return refused_parts(misplaced, drive);
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  SIGHTLINE_ASSIGN(const GivenVerdict verdict,
                   judge_given(drive, limits_of(options), given, odometry));
  if (!verdict.jumps.empty()) return repaired(task, given, verdict.jumps, solve);
  return decide(task, given, odometry, verdict.disagreements, solve);
}

Result<Estimate> refine_given(const EstimateTask& task, const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  const bool compares = options.bad_poses != BadPoses::kIgnore;
  GivenPoses given = given_poses(drive);
  if (compares) {
    SIGHTLINE_ASSIGN(const std::vector<MisplacedPart> misplaced,
                     find_misplaced_parts(drive, given));
    if (!misplaced.empty()) {
      ctx.warn(parts_text(misplaced, drive) + ". Their poses are left out");
      given = without_parts(std::move(given), drive, misplaced);
    }
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  if (compares) {
    SIGHTLINE_ASSIGN(const std::vector<PoseJump> jumps,
                     find_jumps(drive, limits_of(options), given, odometry));
    if (!jumps.empty()) return repaired(task, given, jumps, solve);
  }
  return solve(given, odometry);
}

Result<Drive> undistorted_by_given(PassContext& ctx, const Drive& drive) {
  if (drive.turn_rates.empty() || !has_point_times(drive) || !drive.has_poses()) return drive;
  SIGHTLINE_ASSIGN(const Trajectory given, trajectory_as_given(drive));
  PassContext without_warnings = quiet(ctx);  // undistort-scans gives them
  return change_parts(
      drive, given,
      [&](const Drive& part, const Trajectory& poses) -> Result<std::optional<Drive>> {
        SIGHTLINE_ASSIGN(const Drive turned, with_imu_if_sharper(without_warnings, part, poses));
        if (turned.turn_rates.empty()) return std::optional<Drive>();
        return std::optional(undistorted(turned, poses));
      });
}

}  // namespace sightline
