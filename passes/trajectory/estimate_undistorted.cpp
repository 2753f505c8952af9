#include "passes/trajectory/estimate_undistorted.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "passes/trajectory/sweep/sweep_trial.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"
#include "passes/trajectory/sweep/without_turning.h"

// A scan of 0.1 s at 10 m/s is drawn out by 1 m, and where its sweep begins the world tears. Poses
// of such scans taken as rigid are off by what the tear does to a match, so undistorting with them
// sharpens little; poses estimated from the undistorted scans do not have that error any more.
// Files do not say whether somebody undistorted the scans already, nor does their order. The scans
// say it: undistorted twice they no longer fit each other. With the same poses they say too whether
// turn rates of an inertial unit tell how the vehicle turned.

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

// The middle of a drive, estimated again.
struct Trial {
  Drive timed;  // the whole drive
  Trajectory of_middle;
  double entropy_nat = 0.0;
};

// What the first poses of a way are: those of the scans as they are, or, where turn rates say how
// the vehicle turned meanwhile, those of scans without their turning. Else poses would lie where
// the middle of a sweep was, and the rates would be half a sweep off.
Result<Trajectory> first_poses(PassContext& ctx, const Drive& timed, const Trajectory& rigid,
                               const EstimatePoses& estimate) {
  if (timed.turn_rates.empty()) return rigid;
  return estimate(ctx, without_turning(timed));
}

// The sharpest of the ways in which the scans may have been measured. None where there is none, and
// where all fail: a trial that fails says nothing for undistorting.
Result<std::optional<Trial>> sharpest_trial(PassContext& ctx, const std::vector<Drive>& ways,
                                            const Trajectory& rigid,
                                            const EstimatePoses& estimate) {
  std::optional<Trial> best;
  for (const Drive& timed : ways) {
    const Drive middle = middle_of(timed);
    const Result<Trajectory> first = first_poses(ctx, middle, middle_of(rigid, timed), estimate);
    if (!first) continue;
    const Result<Trajectory> after = estimate_again(ctx, middle, *first, estimate);
    if (!after) continue;
    SIGHTLINE_ASSIGN(const double nat,
                     middle_entropy_nat(ctx, undistorted(middle, *after), *after));
    if (!best || nat < best->entropy_nat) best = {timed, *after, nat};
  }
  return best;
}

Result<std::vector<Drive>> ways_of(const Drive& drive, const Trajectory& rigid) {
  const bool has_times =
      std::ranges::any_of(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  const Drive even = without_turns(drive);
  if (!has_times) return swept_drives(even, rigid);
  std::vector<Drive> ways = {even};
  if (!drive.turn_rates.empty()) ways.push_back(drive);
  return ways;
}

}  // namespace

Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate) {
  SIGHTLINE_ASSIGN(const std::vector<Drive> ways, ways_of(drive, rigid));
  if (ways.empty()) return rigid;
  PassContext quiet;
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  SIGHTLINE_ASSIGN(const std::optional<Trial> trial, sharpest_trial(quiet, ways, rigid, estimate));
  if (!trial) return rigid;
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(quiet, drive, rigid));
  if (!is_sharper(trial->entropy_nat, before_nat)) return rigid;
  if (trial->of_middle.poses.size() == rigid.poses.size()) return trial->of_middle;
  SIGHTLINE_ASSIGN(const Trajectory first, first_poses(quiet, trial->timed, rigid, estimate));
  return estimate_again(quiet, trial->timed, first, estimate);
}

}  // namespace sightline
