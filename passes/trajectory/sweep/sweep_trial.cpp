#include "passes/trajectory/sweep/sweep_trial.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

// Enough way to measure things from several sides.
constexpr std::size_t kTrialScans = 60;
// Entropies by two sets of poses differ by a few hundredths where neither is better.
constexpr double kSharper_nat = 0.05;

// Undistorting does not change scans of a vehicle that hardly moves.
constexpr double kLeastWay_m = 5.0;

struct Stretch {
  std::size_t first = 0;
  std::size_t count = 0;
};

// Way along the poses, with no step from one piece to the next.
std::vector<double> driven_m(const Trajectory& trajectory) {
  std::vector<double> driven = {0.0};
  for (std::size_t i = 1; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& from = trajectory.poses[i - 1];
    const TrajectoryPose& to = trajectory.poses[i];
    const double step_m =
        (to.T_map_vehicle.translation() - from.T_map_vehicle.translation()).norm();
    driven.push_back(driven.back() + (from.piece == to.piece ? step_m : 0.0));
  }
  return driven;
}

// The scans nearest to the middle on which the vehicle moves; those of the middle where it never
// does.
Stretch middle_stretch(const Trajectory& trajectory) {
  const std::size_t all = trajectory.poses.size();
  const std::size_t count = std::min(kTrialScans, all);
  const Stretch middle{(all - count) / 2, count};
  if (count < 2) return middle;
  const std::vector<double> driven = driven_m(trajectory);
  const auto moves = [&](std::size_t first) {
    return driven[first + count - 1] - driven[first] >= kLeastWay_m;
  };
  for (std::size_t off = 0; off <= all - count; ++off) {
    if (off <= middle.first && moves(middle.first - off)) return {middle.first - off, count};
    if (middle.first + off <= all - count && moves(middle.first + off)) {
      return {middle.first + off, count};
    }
  }
  return middle;
}

}  // namespace

Drive middle_of(const Drive& drive, const Trajectory& trajectory) {
  const auto [first, count] = middle_stretch(trajectory);
  return stretch_of(drive, first, count);
}

Trajectory middle_of(const Trajectory& trajectory) {
  const auto [first, count] = middle_stretch(trajectory);
  return stretch_of(trajectory, first, count);
}

Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory) {
  SIGHTLINE_ASSIGN(const Sharpness sharpness,
                   measure_sharpness(ctx, {}, middle_of(drive, trajectory), middle_of(trajectory)));
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
