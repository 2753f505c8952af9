#include "passes/trajectory/estimate_given.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/drive/drive.h"
#include "passes/pass/notices.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/unconstrained.h"
#include "passes/trajectory/given/disagreements.h"
#include "passes/trajectory/given/lever_arm.h"
#include "passes/trajectory/given/misplaced_parts.h"
#include "passes/trajectory/given/motion_drift.h"
#include "passes/trajectory/given/sharpening.h"
#include "passes/trajectory/local/parts_of_drive.h"
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

// Half of the heading by which given poses may differ from scans (sharpening.cpp). A car that turns
// into a street stays below 0.03 degrees.
constexpr double kMostUneven_rad = 0.1 * std::numbers::pi / 180.0;

// Beyond three standard deviations of given poses, a pose is wrong and not inaccurate.
JumpLimits limits_of(const EstimateTrajectoryOptions& options) {
  return {3.0 * options.prior_sigma_m, 3.0 * options.prior_sigma_deg * std::numbers::pi / 180.0};
}

std::size_t poses_of(const std::vector<PoseJump>& jumps) {
  std::size_t count = 0;
  for (const PoseJump& jump : jumps) count += jump.last - jump.first + 1;
  return count;
}

// One sentence each, without its full stop; the first five places are named.
std::string jumps_text(const std::vector<PoseJump>& jumps, const Drive& drive) {
  return with_first_places(fmt::format("{} of {} given poses of drive {} contradict the scans",
                                       poses_of(jumps), drive.scans.size(), drive.name),
                           jumps, drive);
}

Notice jumps_notice(const std::vector<PoseJump>& jumps, const Drive& drive) {
  const PoseJump& worst = *std::ranges::max_element(jumps, {}, &PoseJump::off_m);
  return {.code = "given-poses-left-out",
          .text = jumps_text(jumps, drive) + ". These are left out, and the others are refined",
          .count = static_cast<std::uint32_t>(jumps.size()),
          .first_scan = drive.scans[worst.first].recording_index,
          .last_scan = drive.scans[worst.last].recording_index,
          .amount = worst.off_m,
          .unit = "m"};
}

Notice parts_notice(const std::vector<MisplacedPart>& parts, const Drive& drive) {
  const MisplacedPart& worst = *std::ranges::max_element(parts, {}, &MisplacedPart::off_m);
  const std::uint32_t scan = drive.scans[worst.worst].recording_index;
  return {.code = "given-poses-left-out",
          .text = parts_text(parts, drive) + ". Their poses are left out",
          .count = static_cast<std::uint32_t>(parts.size()),
          .first_scan = scan,
          .last_scan = scan,
          .amount = worst.off_m,
          .unit = "m"};
}

std::string disagreements_text(const std::vector<PoseDisagreement>& found, const Drive& drive) {
  return with_first_places(fmt::format("given poses and scans disagree on {} stretches of drive {}",
                                       found.size(), drive.name),
                           found, drive);
}

// `what_is_done`: the end of its text.
Notice disagreements_notice(const std::vector<PoseDisagreement>& found, const Drive& drive,
                            const std::string& what_is_done) {
  const PoseDisagreement& worst = *std::ranges::max_element(found, {}, &PoseDisagreement::off_m);
  return {.code = "given-poses-disagree",
          .text = disagreements_text(found, drive) + what_is_done,
          .count = static_cast<std::uint32_t>(found.size()),
          .first_scan = drive.scans[worst.first].recording_index,
          .last_scan = drive.scans[worst.last].recording_index,
          .amount = worst.off_m,
          .unit = "m"};
}

Notice sharpening_notice(const Sharpening& found, const std::vector<WayStretch>& stretches,
                         const Drive& drive) {
  const auto off = [](const WayStretch& stretch) {
    return stretch.off_rad + portable_hypot(stretch.along_m, stretch.aside_m);
  };
  const WayStretch& worst = *std::ranges::max_element(stretches, {}, off);
  const std::string text = fmt::format(
      "given poses of drive {} are refined, since they blur the map: on {} of {} stretches of 50 m "
      "their motion differs from that of the scans, most by {:.2f} m and {:.2f} degrees over 10 m "
      "at scans {} to {} (mean map entropy {:.3f} nat, refined {:.3f} nat). To keep them, set "
      "estimate-trajectory.mode=given",
      drive.name, std::ranges::count_if(stretches, is_doubtful), stretches.size(),
      portable_hypot(worst.along_m, worst.aside_m), worst.off_rad * 180.0 / std::numbers::pi,
      drive.scans[worst.first].recording_index, drive.scans[worst.last].recording_index,
      found.given.entropy_nat, found.refined.entropy_nat);
  return {.code = "given-poses-refined",
          .text = text,
          .count = static_cast<std::uint32_t>(std::ranges::count_if(stretches, is_doubtful)),
          .first_scan = drive.scans[worst.first].recording_index,
          .last_scan = drive.scans[worst.last].recording_index,
          .amount = portable_hypot(worst.along_m, worst.aside_m),
          .unit = "m"};
}

// With these notices first.
Result<Estimate> noted(const std::vector<Notice>& notices, Result<Estimate> estimate) {
  if (!estimate) return estimate;
  std::vector<Notice>& all = estimate->trajectory.notices;
  all.insert(all.begin(), notices.begin(), notices.end());
  return estimate;
}

// Empty where the sensor is where the configuration puts it.
std::string lever_arm_text(const std::optional<Eigen::Vector3d>& arm_m) {
  if (!arm_m) return "";
  return fmt::format(
      ". The scans fit them if the sensor is mounted {:.1f} m farther ahead, {:.1f} m farther left "
      "and {:.1f} m higher in the vehicle: check lidar_x_m, lidar_y_m and lidar_z_m",
      arm_m->x(), arm_m->y(), arm_m->z());
}

Error refused(const std::string& text, const Drive& drive, std::uint32_t scan) {
  const ScanInfo& worst = drive.scans[scan];
  return {ErrorCode::kMismatchedInputs, text, worst.source, concat("scan ", worst.recording_index)};
}

Error refused_jumps(const std::vector<PoseJump>& jumps, const Drive& drive) {
  const auto worst = std::ranges::max_element(jumps, {}, &PoseJump::off_m);
  std::string text = jumps_text(jumps, drive);
  if (2 * poses_of(jumps) > drive.scans.size()) {
    text +=
        ". These are most of them: check the columns, axes and order of the poses, and "
        "lidar_yaw_deg";
  }
  return refused(
      text + ". Correct these poses, or leave them out with estimate-trajectory.bad_poses=repair",
      drive, worst->worst);
}

// Without the poses that the scans contradict.
Result<Estimate> repaired(const EstimateTask& task, const GivenPoses& given,
                          const std::vector<PoseJump>& jumps, const SolvePoses& solve) {
  const EstimateTrajectoryOptions& options = task.options;
  const bool may_repair =
      options.bad_poses == BadPoses::kRepair ||
      (options.mode == PoseMode::kRefine && options.bad_poses == BadPoses::kWarn);
  if (!may_repair) return refused_jumps(jumps, task.drive);
  const Notice notice = warned(task.ctx, jumps_notice(jumps, task.drive));
  GivenPoses used = given;
  for (const PoseJump& jump : jumps) {
    for (std::uint32_t k = jump.first; k <= jump.last; ++k) used[k].reset();
  }
  // Anew: where a scan did not match, odometry continued from its given pose.
  SIGHTLINE_ASSIGN(const Odometry odometry,
                   run_odometry(task.ctx, options.local_map_m, task.drive, used));
  return noted({notice}, solve(used, odometry));
}

Result<Trajectory> trajectory_as_given(const Drive& drive) {
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  for (const ScanInfo& scan : drive.scans) {
    if (!scan.T_world_vehicle) {
      return Error{ErrorCode::kNoPoses, "the recording has no pose for this scan", scan.source,
                   concat("scan ", scan.recording_index)};
    }
    trajectory.poses.push_back({scan.recording_index, scan.stamp_ns,
                                rebase(*scan.T_world_vehicle, MapFrame{}, drive.frame)});
  }
  return trajectory;
}

// Root mean square of what turning from pose to pose may be off from an even one in the middle
// between them: an eighth of the change of two steps' turning.
double uneven_turning_rad(const Drive& drive, const Trajectory& given) {
  const std::vector<TrajectoryPose> poses = poses_of_first_sensor(drive, given).poses;
  double sum_rad2 = 0.0;
  double count = 0.0;
  for (std::size_t i = 2; i < poses.size(); ++i) {
    const Eigen::Matrix3d before =
        poses[i - 2].T_map_vehicle.linear().transpose() * poses[i - 1].T_map_vehicle.linear();
    const Eigen::Matrix3d after =
        poses[i - 1].T_map_vehicle.linear().transpose() * poses[i].T_map_vehicle.linear();
    const double off_rad = rotation_angle_rad(before.transpose() * after) / 8.0;
    sum_rad2 += off_rad * off_rad;
    count += 1.0;
  }
  return std::sqrt(sum_rad2 / std::max(count, 1.0));
}

// Refined, with a warning, where the scans then fit each other more sharply; else none.
Result<std::optional<Estimate>> sharpened(const EstimateTask& task, double uneven_rad,
                                          const GivenPoses& given, const Odometry& odometry,
                                          const std::vector<PoseDisagreement>& disagreements,
                                          const SolvePoses& solve) {
  const std::optional<Estimate> none;
  const std::vector<WayStretch> stretches = stretches_of(given, odometry, disagreements);
  if (std::ranges::none_of(stretches, is_doubtful)) return none;
  if (uneven_rad > kMostUneven_rad) {
    task.ctx.inform(
        fmt::format("drive {}: given poses are kept where the scans move otherwise: the vehicle "
                    "turned unevenly "
                    "during scans (by {:.2f} degrees), and no turn rates correct that",
                    task.drive.name, uneven_rad * 180.0 / std::numbers::pi));
    return none;
  }
  SIGHTLINE_ASSIGN(Estimate refined, solve(given, odometry));
  SIGHTLINE_ASSIGN(const Sharpening sharpening,
                   compare_sharpness(task.ctx, task.drive, stretches, given,
                                     sensor_poses(task.drive, refined.trajectory)));
  if (!sharpening.is_sharper) return none;
  Notice notice = sharpening_notice(sharpening, stretches, task.drive);
  notice.text += lever_arm_text(lever_arm_m(task.drive, given, odometry));
  refined.trajectory.notices.push_back(warned(task.ctx, std::move(notice)));
  return std::optional<Estimate>(std::move(refined));
}

// The wrong scale of given poses, where they have one. Error: mismatched-inputs (they drift from
// the scans).
Result<std::vector<Notice>> check_drift(const EstimateTask& task, const GivenPoses& given,
                                        const Odometry& odometry) {
  const auto& [ctx, options, drive] = task;
  const std::vector<MotionDrift> drifts = find_drifts(limits_of(options), given, odometry);
  if (!drifts.empty() && options.bad_poses != BadPoses::kRepair) {
    return refused(
        with_first_places(
            concat("given poses of drive ", drive.name, " drift from the motion in the scans"),
            drifts, drive) +
            ". Check the scale, axes and times of the poses and lidar_yaw_deg, or refine "
            "them with estimate-trajectory.bad_poses=repair",
        drive, drifts.front().first);
  }
  const std::optional<double> scale = find_scale_error(given, odometry);
  if (!scale) return std::vector<Notice>();
  const double wrong = 100.0 * std::abs(*scale);
  return std::vector{warned(
      ctx, {.code = "given-poses-scale",
            .text = fmt::format(
                "given poses of drive {} move {:.1f} % {} than the scans show. Check their scale "
                "(wheel size, map projection) and the range calibration of the sensor",
                drive.name, wrong, *scale > 0.0 ? "farther" : "less far"),
            .amount = wrong,
            .unit = "%"})};
}

// The given poses, or refined ones, by where the given ones disagree with odometry.
Result<Estimate> decide(const EstimateTask& task, double uneven_rad, const GivenPoses& given,
                        const Odometry& odometry,
                        const std::vector<PoseDisagreement>& disagreements,
                        const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  const bool disagrees = !disagreements.empty();
  if (disagrees && options.bad_poses == BadPoses::kRefuse) {
    return refused(disagreements_text(disagreements, drive), drive, disagreements.front().first);
  }
  if (disagrees && options.bad_poses == BadPoses::kRepair) {
    const Notice notice =
        warned(ctx, disagreements_notice(disagreements, drive, ". They are refined"));
    return noted({notice}, solve(given, odometry));
  }
  std::optional<Estimate> refined;
  if (options.mode == PoseMode::kAuto) {
    SIGHTLINE_ASSIGN(refined, sharpened(task, uneven_rad, given, odometry, disagreements, solve));
  }
  std::vector<Notice> notices;
  if (disagrees) {
    notices.push_back(warned(
        ctx, disagreements_notice(disagreements, drive,
                                  refined ? ""
                                          : ". The given poses are used; to refine them, set "
                                            "estimate-trajectory.bad_poses=repair")));
  }
  if (refined) return noted(notices, *std::move(refined));
  SIGHTLINE_ASSIGN(Trajectory unchanged, trajectory_as_given(drive));
  mark_unconstrained(odometry, unchanged.poses);
  return noted(notices, Estimate{std::move(unchanged), {}});
}

Result<Estimate> judged(const EstimateTask& task, double uneven_rad, const GivenPoses& given,
                        const Odometry& odometry, const SolvePoses& solve) {
  SIGHTLINE_ASSIGN(const std::vector<PoseJump> jumps,
                   find_jumps(task.drive, limits_of(task.options), given, odometry));
  if (!jumps.empty()) return repaired(task, given, jumps, solve);
  SIGHTLINE_ASSIGN(const std::vector<Notice> notices, check_drift(task, given, odometry));
  SIGHTLINE_ASSIGN(const std::vector<PoseDisagreement> disagreements,
                   find_disagreements(task.drive, given, odometry));
  return noted(notices, decide(task, uneven_rad, given, odometry, disagreements, solve));
}

// Poses at the times of the scans by another clock are judged instead of those given.
Result<Estimate> judged_by_clock(const EstimateTask& task, double uneven_rad,
                                 const ClockShift& shift, const Odometry& odometry,
                                 const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  if (options.bad_poses == BadPoses::kRefuse) return refused(to_text(shift, drive), drive, 0);
  const Notice notice = warned(
      ctx, {.code = "given-poses-clock",
            .text = to_text(shift, drive) + ". These are used; correct the times of the poses",
            .amount = 1e-9 * static_cast<double>(shift.ahead_ns),
            .unit = "s"});
  const Drive of_clock = with_clock(drive, shift, odometry);
  const GivenPoses given = given_poses(of_clock);
  SIGHTLINE_ASSIGN(const Odometry again, run_odometry(ctx, options.local_map_m, of_clock, given));
  return noted({notice}, judged({ctx, options, of_clock}, uneven_rad, given, again, solve));
}

}  // namespace

Result<Estimate> check_given(const EstimateTask& task, double uneven_rad, const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  SIGHTLINE_ASSIGN(Trajectory unchanged, trajectory_as_given(drive));
  if (options.bad_poses == BadPoses::kIgnore || drive.scans.size() < 2) {
    return Estimate{std::move(unchanged), {}};
  }
  const GivenPoses given = given_poses(drive);
  SIGHTLINE_ASSIGN(const std::vector<MisplacedPart> misplaced, find_misplaced_parts(drive, given));
  if (!misplaced.empty()) {
    if (options.bad_poses == BadPoses::kRepair) return refine_given(task, solve);
    return refused(
        parts_text(misplaced, drive) +
            ". To align these drives by their scans, set estimate-trajectory.bad_poses=repair",
        drive, misplaced.front().worst);
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  const std::optional<ClockShift> shift = find_clock_shift(drive, given, odometry);
  if (shift) return judged_by_clock(task, uneven_rad, *shift, odometry, solve);
  return judged(task, uneven_rad, given, odometry, solve);
}

Result<Estimate> refine_given(const EstimateTask& task, const SolvePoses& solve) {
  const auto& [ctx, options, drive] = task;
  const bool compares = options.bad_poses != BadPoses::kIgnore;
  GivenPoses given = given_poses(drive);
  std::vector<Notice> notices;
  if (compares) {
    SIGHTLINE_ASSIGN(const std::vector<MisplacedPart> misplaced,
                     find_misplaced_parts(drive, given));
    if (!misplaced.empty()) {
      notices.push_back(warned(ctx, parts_notice(misplaced, drive)));
      given = without_parts(std::move(given), drive, misplaced);
    }
  }
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  if (compares) {
    SIGHTLINE_ASSIGN(const std::vector<PoseJump> jumps,
                     find_jumps(drive, limits_of(options), given, odometry));
    if (!jumps.empty()) return noted(notices, repaired(task, given, jumps, solve));
  }
  return noted(notices, solve(given, odometry));
}

Result<StraightDrive> undistorted_by_given(PassContext& ctx, const Drive& drive) {
  if (!has_point_times(drive) || !drive.has_poses()) return StraightDrive{drive};
  SIGHTLINE_ASSIGN(const Trajectory given, trajectory_as_given(drive));
  PassContext without_warnings = quiet(ctx);  // undistort-scans gives them
  double uneven_rad = 0.0;
  SIGHTLINE_ASSIGN(
      Drive straight_drive,
      change_parts(drive, given,
                   [&](const Drive& part, const Trajectory& poses) -> Result<std::optional<Drive>> {
                     if (!has_point_times(part)) return std::optional<Drive>();
                     SIGHTLINE_ASSIGN(const Drive turned,
                                      with_imu_if_sharper(without_warnings, part, poses));
                     const Drive straight = undistorted(turned, poses);
                     if (!turned.turn_rates.empty()) return std::optional(straight);
                     uneven_rad = std::max(uneven_rad, uneven_turning_rad(part, poses));
                     SIGHTLINE_ASSIGN(
                         const bool is_sharper,
                         is_sharper_undistorted(without_warnings, part, straight, poses));
                     return is_sharper ? std::optional(straight) : std::nullopt;
                   }));
  return StraightDrive{std::move(straight_drive), uneven_rad};
}

}  // namespace sightline
