#include "passes/trajectory/undistort_scans.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "formats/drive/trajectory_of_drive.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/sweep_trial.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

// By times that nobody wrote down, where that makes the scans fit each other better; none where it
// does not.
Result<std::optional<Drive>> undistorted_by_order(PassContext& ctx, const Drive& drive,
                                                  const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(std::optional<Drive> swept,
                   sharpest_sweep(ctx, without_turns(drive), trajectory));
  if (!swept) return swept;
  swept->turn_rates = drive.turn_rates;
  SIGHTLINE_ASSIGN(const Drive turned, with_turns_that_pay(ctx, *swept, trajectory));
  const Drive straight = undistorted(turned, trajectory);
  SIGHTLINE_ASSIGN(const bool is_sharper, is_sharper_undistorted(ctx, drive, straight, trajectory));
  return is_sharper ? std::optional(straight) : std::nullopt;
}

std::size_t timed_scans(const Drive& drive) {
  return static_cast<std::size_t>(std::ranges::count_if(
      drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; }));
}

// Of a drive of one part; none: its scans stay as they are.
Result<std::optional<Drive>> undistorted_part(PassContext& ctx, const Drive& drive,
                                              const Trajectory& trajectory) {
  if (timed_scans(drive) == 0) return undistorted_by_order(ctx, drive, trajectory);
  const std::size_t still = scans_without_motion(drive, trajectory);
  if (still > 0) {
    ctx.warn("drive " + drive.name + ": " + std::to_string(still) +
             " scans have no other pose within 1.5 s; they are taken to stand still");
  }
  SIGHTLINE_ASSIGN(const Drive turned, with_turns_that_pay(ctx, drive, trajectory));
  return std::optional(undistorted(turned, trajectory));
}

}  // namespace

std::vector<OptionField> option_fields(UndistortScansOptions& options) {
  return {flag("enabled", options.enabled,
               "take the vehicle's motion during a scan out of it, where its points carry times")};
}

Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!options.enabled) {
    const std::size_t timed = timed_scans(drive);
    if (timed > 0) {
      ctx.warn("drive " + drive.name + ": " + std::to_string(timed) +
               " scans have point times that are not used: undistort-scans is off");
    }
    return drive;
  }
  std::vector<Drive> parts = parts_of(drive);
  const std::vector<Trajectory> poses = trajectories_of_parts(parts, trajectory);
  bool is_changed = false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SIGHTLINE_ASSIGN(std::optional<Drive> straight, undistorted_part(ctx, parts[i], poses[i]));
    if (!straight) continue;
    parts[i] = *std::move(straight);
    is_changed = true;
  }
  return is_changed ? joined_again(drive, parts) : drive;
}

}  // namespace sightline
