#include "passes/trajectory/undistort_scans.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

// Undistorted by times from the order of points, where scans are then sharper; else none.
Result<std::optional<Drive>> undistorted_by_order(PassContext& ctx, const Drive& drive,
                                                  const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(std::optional<Drive> swept,
                   sharpest_sweep(ctx, without_turns(drive), trajectory));
  if (!swept) return swept;
  swept->turn_rates = drive.turn_rates;
  SIGHTLINE_ASSIGN(const Drive turned, with_imu_if_sharper(ctx, *swept, trajectory));
  const Drive straight = undistorted(turned, trajectory);
  SIGHTLINE_ASSIGN(const bool is_sharper, is_sharper_undistorted(ctx, drive, straight, trajectory));
  return is_sharper ? std::optional(straight) : std::nullopt;
}

// A drive of one part, undistorted; none: its scans stay as they are.
Result<std::optional<Drive>> undistorted_part(PassContext& ctx, const Drive& drive,
                                              const Trajectory& trajectory) {
  if (!has_point_times(drive)) return undistorted_by_order(ctx, drive, trajectory);
  const std::size_t still = scans_without_motion(drive, trajectory);
  if (still > 0) {
    ctx.warn(concat("drive ", drive.name, ": ", still,
                    " scans have no other pose within 1.5 s; the vehicle is assumed to stand still "
                    "during them"));
  }
  SIGHTLINE_ASSIGN(const Drive turned, with_imu_if_sharper(ctx, drive, trajectory));
  return std::optional(undistorted(turned, trajectory));
}

}  // namespace

std::vector<OptionField> option_fields(UndistortScansOptions& options) {
  return {flag("enabled", options.enabled,
               "correct scans for the vehicle's motion during the scan, where points have times")};
}

Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!options.enabled) {
    const auto timed = std::ranges::count_if(drive.scans, &ScanInfo::has_point_times);
    if (timed > 0) {
      ctx.warn(
          concat("drive ", drive.name, ": ", timed,
                 " scans have point times that are not used: undistort-scans.enabled is false"));
    }
    return drive;
  }
  return change_parts(drive, trajectory, [&](const Drive& part, const Trajectory& poses) {
    return undistorted_part(ctx, part, poses);
  });
}

}  // namespace sightline
