#include "passes/trajectory/sweep/sweep_trial.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/stretch_of_drive.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

// The trial takes the middle of a drive: enough way that things are seen from several sides.
constexpr std::size_t kTrialScans = 60;
// Entropies of two ways to lay a drive differ by a few hundredths where nothing is gained.
constexpr double kSharper_nat = 0.05;

struct Stretch {
  std::size_t first = 0;
  std::size_t count = 0;
};

// Of the drive's longest part.
Stretch middle_stretch(const Drive& drive) {
  Stretch longest;
  Stretch part;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (i > 0 && drive.scans[i].part != drive.scans[i - 1].part) part = {i, 0};
    ++part.count;
    if (part.count > longest.count) longest = part;
  }
  const std::size_t count = std::min(kTrialScans, longest.count);
  return {longest.first + (longest.count - count) / 2, count};
}

}  // namespace

Drive middle_of(const Drive& drive) {
  const auto [first, count] = middle_stretch(drive);
  return stretch_of(drive, first, count);
}

Trajectory middle_of(const Trajectory& trajectory, const Drive& drive) {
  const auto [first, count] = middle_stretch(drive);
  Trajectory middle = trajectory;
  middle.poses = {trajectory.poses.begin() + static_cast<std::ptrdiff_t>(first),
                  trajectory.poses.begin() + static_cast<std::ptrdiff_t>(first + count)};
  const std::uint32_t first_piece = middle.poses.empty() ? 0 : middle.poses.front().piece;
  for (TrajectoryPose& pose : middle.poses) pose.piece -= first_piece;
  return middle;
}

Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const Sharpness sharpness,
                   measure_sharpness(ctx, {}, middle_of(drive), middle_of(trajectory, drive)));
  return sharpness.of_map.mean_entropy_nat;
}

bool is_sharper(double after_nat, double before_nat) {
  return after_nat < before_nat - kSharper_nat;
}

Result<std::optional<Drive>> sharpest_sweep(PassContext& ctx, const Drive& drive,
                                            const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const std::vector<Drive> sweeps, swept_drives(drive, trajectory));
  std::optional<Drive> best;
  if (sweeps.size() == 1) best = sweeps.front();
  if (sweeps.size() < 2) return best;
  double least_nat = std::numeric_limits<double>::infinity();
  for (const Drive& swept : sweeps) {
    SIGHTLINE_ASSIGN(const double nat,
                     middle_entropy_nat(ctx, undistorted(swept, trajectory), trajectory));
    if (nat >= least_nat) continue;
    least_nat = nat;
    best = swept;
  }
  return best;
}

Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(ctx, drive, trajectory));
  SIGHTLINE_ASSIGN(const double after_nat, middle_entropy_nat(ctx, undistorted, trajectory));
  return is_sharper(after_nat, before_nat);
}

}  // namespace sightline
