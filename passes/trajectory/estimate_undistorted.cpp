#include "passes/trajectory/estimate_undistorted.h"

#include <algorithm>
#include <utility>

#include "passes/trajectory/sweep/sweep_trial.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/undistort_scans.h"

// A scan of 0.1 s at 10 m/s is drawn out by 1 m, and where its sweep begins the world tears. Poses
// of such scans taken as rigid are off by what the tear does to a match, so undistorting with them
// sharpens little; poses estimated from the undistorted scans do not have that error any more.
// Files do not say whether somebody undistorted the scans already, nor does their order. The scans
// say it: undistorted twice they no longer fit each other.

namespace sightline {
namespace {

constexpr int kRounds = 2;

Result<Trajectory> estimate_again(PassContext& ctx, const Drive& timed, Trajectory trajectory,
                                  const EstimatePoses& estimate) {
  for (int round = 0; round < kRounds; ++round) {
    SIGHTLINE_ASSIGN(trajectory, estimate(ctx, undistorted(timed, trajectory)));
  }
  return trajectory;
}

}  // namespace

Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate) {
  SIGHTLINE_ASSIGN(const Drive timed, with_sweep_times(drive));
  const bool has_times =
      std::ranges::any_of(timed.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (!has_times) return rigid;
  PassContext quiet;
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  const Drive middle = middle_of(timed);
  const Trajectory before = middle_of(rigid, timed);
  const Result<Trajectory> after = estimate_again(quiet, middle, before, estimate);
  // A trial that fails says nothing for undistorting.
  if (!after) return rigid;
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(quiet, middle, before));
  SIGHTLINE_ASSIGN(const double after_nat,
                   middle_entropy_nat(quiet, undistorted(middle, *after), *after));
  if (!is_sharper(after_nat, before_nat)) return rigid;
  if (middle.scans.size() == timed.scans.size()) return after;
  return estimate_again(quiet, timed, rigid, estimate);
}

}  // namespace sightline
