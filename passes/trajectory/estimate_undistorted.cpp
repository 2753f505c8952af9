#include "passes/trajectory/estimate_undistorted.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "passes/trajectory/local/parts_of_drive.h"
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

// A drive or a part of one, and how its scans were measured, if not all points at once.
struct Measured {
  Drive drive;
  std::optional<Drive> timed;
};

// The whole of parts, each as `change` makes it of its timed form.
template <class Change>
Drive changed(const Drive& drive, const std::vector<Measured>& parts, const Change& change) {
  std::vector<Drive> of_parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    of_parts.push_back(parts[i].timed ? change(*parts[i].timed, i) : parts[i].drive);
  }
  return joined_again(drive, of_parts);
}

std::vector<Drive> drives_of(const std::vector<Measured>& parts) {
  std::vector<Drive> drives;
  for (const Measured& part : parts) drives.push_back(part.drive);
  return drives;
}

Result<Trajectory> estimate_again(PassContext& ctx, const Drive& drive,
                                  const std::vector<Measured>& parts, Trajectory trajectory,
                                  const EstimatePoses& estimate) {
  const std::vector<Drive> as_they_are = drives_of(parts);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Trajectory> poses = trajectories_of_parts(as_they_are, trajectory);
    const Drive straight = changed(drive, parts, [&](const Drive& timed, std::size_t i) {
      return undistorted(timed, poses[i]);
    });
    SIGHTLINE_ASSIGN(trajectory, estimate(ctx, straight));
  }
  return trajectory;
}

// What the first poses of a way are: those of the scans as they are, or, where turn rates say how
// the vehicle turned meanwhile, those of scans without their turning. Else poses would lie where
// the middle of a sweep was, and the rates would be half a sweep off.
Result<Trajectory> first_poses(PassContext& ctx, const Drive& drive,
                               const std::vector<Measured>& parts, const Trajectory& rigid,
                               const EstimatePoses& estimate) {
  const bool has_rates = std::ranges::any_of(
      parts, [](const Measured& part) { return part.timed && !part.timed->turn_rates.empty(); });
  if (!has_rates) return rigid;
  return estimate(ctx, changed(drive, parts, [](const Drive& timed, std::size_t) {
                    return timed.turn_rates.empty() ? timed : without_turning(timed);
                  }));
}

Result<Trajectory> estimate_as_measured(PassContext& ctx, const Drive& drive,
                                        const std::vector<Measured>& parts, const Trajectory& rigid,
                                        const EstimatePoses& estimate) {
  SIGHTLINE_ASSIGN(const Trajectory first, first_poses(ctx, drive, parts, rigid, estimate));
  return estimate_again(ctx, drive, parts, first, estimate);
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

// The middle of a drive, estimated again.
struct Trial {
  Drive timed;  // the whole drive
  Trajectory of_middle;
  double entropy_nat = 0.0;
};

// Whether an error means that a trial does not work: its scans cannot be followed, are too few, or
// contradict given poses. Any other, such as a scan that cannot be read, is none of its timing;
// skipped, it would quietly lead to other poses.
bool is_failed_trial(const Error& error) {
  return error.code == ErrorCode::kTrajectoryLost || error.code == ErrorCode::kDriveTooShort ||
         error.code == ErrorCode::kMismatchedInputs;
}

// The sharpest of the ways in which the scans of a drive of one part may have been measured. None
// where there is none, and where every trial fails.
Result<std::optional<Trial>> sharpest_trial(PassContext& ctx, const std::vector<Drive>& ways,
                                            const Trajectory& rigid,
                                            const EstimatePoses& estimate) {
  std::optional<Trial> best;
  for (const Drive& timed : ways) {
    const Drive middle = middle_of(timed, rigid);
    const Result<Trajectory> after =
        estimate_as_measured(ctx, middle, {{middle, middle}}, middle_of(rigid), estimate);
    if (!after && is_failed_trial(after.error())) continue;
    if (!after) return after.error();
    SIGHTLINE_ASSIGN(const double nat,
                     middle_entropy_nat(ctx, undistorted(middle, *after), *after));
    if (!best || nat < best->entropy_nat) best = {timed, *after, nat};
  }
  return best;
}

// None where the scans lie no more sharply undistorted than as they are.
Result<std::optional<Trial>> trial_that_pays(PassContext& ctx, const Drive& drive,
                                             const Trajectory& rigid,
                                             const EstimatePoses& estimate) {
  SIGHTLINE_ASSIGN(const std::vector<Drive> ways, ways_of(drive, rigid));
  if (ways.empty()) return std::optional<Trial>();
  SIGHTLINE_ASSIGN(std::optional<Trial> trial, sharpest_trial(ctx, ways, rigid, estimate));
  if (!trial) return trial;
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(ctx, drive, rigid));
  if (!is_sharper(trial->entropy_nat, before_nat)) trial.reset();
  return trial;
}

}  // namespace

Result<Trajectory> estimate_undistorted(PassContext& ctx, const Drive& drive,
                                        const Trajectory& rigid, const EstimatePoses& estimate) {
  PassContext quiet;
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  const std::vector<Drive> parts = parts_of(drive);
  const std::vector<Trajectory> rigid_parts = trajectories_of_parts(parts, rigid);
  std::vector<Measured> measured;
  bool are_rigid = true;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    measured.push_back({parts[i], std::nullopt});
    SIGHTLINE_ASSIGN(std::optional<Trial> trial,
                     trial_that_pays(quiet, parts[i], rigid_parts[i], estimate));
    if (!trial) continue;
    if (trial->of_middle.poses.size() == rigid.poses.size()) return trial->of_middle;
    measured.back().timed = std::move(trial->timed);
    are_rigid = false;
  }
  if (are_rigid) return rigid;
  return estimate_as_measured(quiet, drive, measured, rigid, estimate);
}

}  // namespace sightline
