#include "passes/trajectory/undistort_scans.h"

#include <algorithm>
#include <optional>

#include "formats/drive/trajectory_of_drive.h"
#include "passes/trajectory/sweep/sweep_trial.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

// By times that nobody wrote down, where that makes the scans fit each other better.
Result<Drive> undistorted_by_order(PassContext& ctx, const Drive& drive,
                                   const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(std::optional<Drive> swept,
                   sharpest_sweep(ctx, without_turns(drive), trajectory));
  if (!swept) return drive;
  swept->turn_rates = drive.turn_rates;
  SIGHTLINE_ASSIGN(const Drive turned, with_turns_that_pay(ctx, *swept, trajectory));
  const Drive straight = undistorted(turned, trajectory);
  SIGHTLINE_ASSIGN(const bool is_sharper, is_sharper_undistorted(ctx, drive, straight, trajectory));
  return is_sharper ? straight : drive;
}

}  // namespace

std::vector<OptionField> option_fields(UndistortScansOptions& options) {
  return {flag("enabled", options.enabled,
               "take the vehicle's motion during a scan out of it, where its points carry times")};
}

Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  const auto timed =
      std::ranges::count_if(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (timed == 0) return options.enabled ? undistorted_by_order(ctx, drive, trajectory) : drive;
  const std::string name = "drive " + drive.name + ": ";
  if (!options.enabled) {
    ctx.warn(name + std::to_string(timed) +
             " scans have point times that are not used: undistort-scans is off");
    return drive;
  }
  const std::size_t still = scans_without_motion(drive, trajectory);
  if (still > 0) {
    ctx.warn(name + std::to_string(still) +
             " scans have no other pose within 1.5 s; they are taken to stand still");
  }
  SIGHTLINE_ASSIGN(const Drive turned, with_turns_that_pay(ctx, drive, trajectory));
  return undistorted(turned, trajectory);
}

}  // namespace sightline
