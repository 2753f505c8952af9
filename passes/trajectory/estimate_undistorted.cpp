#include "passes/trajectory/estimate_undistorted.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "passes/pass/pass_context.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/swept_drive.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

// During a scan of 0.1 s at 10 m/s the sensor moves 1 m, so the end of a sweep does not fit its
// beginning. This gap biases the poses of scans that are taken as rigid, and undistorting with
// biased poses sharpens little; poses estimated from undistorted scans are not biased. Neither a
// file nor the order of its points shows whether scans were undistorted already. Their sharpness
// does: undistorted twice, scans fit each other worse. It also shows whether turn rates of an
// inertial unit are those of the vehicle.

namespace sightline {
namespace {

constexpr int kRounds = 2;

// A drive or a part of one, and its scans with times; none where they stay rigid.
struct Measured {
  Drive drive;
  std::optional<Drive> timed;
};

// The whole drive, with `change` applied to the timed form of each part.
template <class Change>
Drive changed(const Drive& drive, const std::vector<Measured>& parts, const Change& change) {
  std::vector<Drive> of_parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    of_parts.push_back(parts[i].timed ? change(*parts[i].timed, i) : parts[i].drive);
  }
  return joined_again(drive, of_parts);
}

Drive undistorted_parts(const Drive& drive, const std::vector<Measured>& parts,
                        const Trajectory& trajectory) {
  std::vector<Drive> as_they_are;
  for (const Measured& part : parts) as_they_are.push_back(part.drive);
  const std::vector<Trajectory> poses = trajectories_of_parts(as_they_are, trajectory);
  return changed(drive, parts,
                 [&](const Drive& timed, std::size_t i) { return undistorted(timed, poses[i]); });
}

// The estimate that undistorting starts with: that of the scans as they are or, with turn rates, of
// scans without the turning that these measured. Otherwise poses would be those of the middle of a
// sweep, and the rates half a sweep off.
Result<Estimate> first_estimate(PassContext& ctx, const Drive& drive,
                                const std::vector<Measured>& parts, const Estimate& rigid,
                                const EstimatePoses& estimate) {
  const bool has_rates = std::ranges::any_of(
      parts, [](const Measured& part) { return part.timed && !part.timed->turn_rates.empty(); });
  if (!has_rates) return rigid;
  return estimate(ctx, changed(drive, parts, [](const Drive& timed, std::size_t) {
                    return timed.turn_rates.empty() ? timed : without_turning(timed);
                  }));
}

Result<Estimate> estimate_as_measured(PassContext& ctx, const Drive& drive,
                                      const std::vector<Measured>& parts, const Estimate& rigid,
                                      const EstimatePoses& estimate, int rounds) {
  SIGHTLINE_ASSIGN(Estimate latest, first_estimate(ctx, drive, parts, rigid, estimate));
  for (int round = 0; round < rounds; ++round) {
    SIGHTLINE_ASSIGN(latest, estimate(ctx, undistorted_parts(drive, parts, latest.trajectory)));
  }
  return latest;
}

// The timings to be tried.
Result<std::vector<Drive>> timed_drives(const Drive& drive, const Trajectory& rigid) {
  const Drive even = without_turns(drive);
  if (!has_point_times(drive)) return swept_drives(even, rigid);
  std::vector<Drive> timed = {even};
  if (!drive.turn_rates.empty()) timed.push_back(drive);
  return timed;
}

// A timing of a drive, and the estimate of its middle by it.
struct Trial {
  Drive timed;  // the whole drive
  Estimate of_middle;
  double entropy_nat = 0.0;
};

// Whether the middle of a drive is all of it.
bool covers_drive(const Trial& trial, const Estimate& rigid) {
  return trial.of_middle.trajectory.poses.size() == rigid.trajectory.poses.size();
}

// Whether an error means that a trial does not work: its scans cannot be followed, are too few, or
// contradict given poses. Any other, such as a scan that cannot be read, does not come from the
// timing and must be returned; skipped, it would lead to other poses without a word.
bool is_failed_trial(const Error& error) {
  return error.code == ErrorCode::kTrajectoryLost || error.code == ErrorCode::kDriveTooShort ||
         error.code == ErrorCode::kMismatchedInputs;
}

// Scans that lie on each other are the sharpest, so that entropy falls where a way is shortened. By
// undistorting, ways change by a few percent, and by centimetres where a vehicle stands.
constexpr double kMostOtherShare = 0.1;
constexpr double kMostOtherWay_m = 0.5;

// Whether a trial has moved as the first estimate did, so that entropies can be compared.
bool has_same_way(const Trajectory& trial, const Trajectory& rigid) {
  const double trial_m = way_m(trial);
  const double rigid_m = way_m(rigid);
  return std::abs(trial_m - rigid_m) <= kMostOtherWay_m + kMostOtherShare * rigid_m;
}

// More rounds of a trial, from the estimate of its middle so far. None where it fails.
Result<std::optional<Trial>> continued(PassContext& ctx, const Drive& middle, const Trial& trial,
                                       const EstimatePoses& estimate, int rounds) {
  Result<Estimate> after =
      estimate_as_measured(ctx, middle, {{middle, middle}}, trial.of_middle, estimate, rounds);
  if (!after && is_failed_trial(after.error())) return std::optional<Trial>();
  if (!after) return after.error();
  const Trajectory& poses = after->trajectory;
  if (!has_same_way(poses, trial.of_middle.trajectory)) return std::optional<Trial>();
  SIGHTLINE_ASSIGN(const double nat, middle_entropy_nat(ctx, undistorted(middle, poses), poses));
  return std::optional<Trial>({trial.timed, *std::move(after), nat});
}

// The sharpest of several timings of a drive of one part. None where every trial fails.
Result<std::optional<Trial>> sharpest_trial(PassContext& ctx, const std::vector<Drive>& timed,
                                            const Estimate& rigid, const EstimatePoses& estimate,
                                            int rounds) {
  std::optional<Trial> best;
  for (const Drive& one : timed) {
    const Trial begin{one, {middle_of(rigid.trajectory), {}}};
    SIGHTLINE_ASSIGN(std::optional<Trial> trial,
                     continued(ctx, middle_of(one, rigid.trajectory), begin, estimate, rounds));
    if (trial && (!best || trial->entropy_nat < best->entropy_nat)) best = std::move(trial);
  }
  return best;
}

// A round after the first one changes the entropy by a few hundredths of a nat: scans that are
// blurred by more were undistorted before.
constexpr double kMostGain_nat = 0.1;

// None where scans are no sharper undistorted than as they are. Timings by the order of points
// differ clearly after one round; another one is made only where it can change the answer, or its
// poses are used.
Result<std::optional<Trial>> best_deskew_trial(PassContext& ctx, const Drive& drive,
                                               const Estimate& rigid,
                                               const EstimatePoses& estimate) {
  const int rounds = has_point_times(drive) ? kRounds : 1;
  SIGHTLINE_ASSIGN(const std::vector<Drive> timed, timed_drives(drive, rigid.trajectory));
  SIGHTLINE_ASSIGN(std::optional<Trial> trial, sharpest_trial(ctx, timed, rigid, estimate, rounds));
  if (!trial) return trial;
  SIGHTLINE_ASSIGN(const double before_nat, middle_entropy_nat(ctx, drive, rigid.trajectory));
  const bool is_clear =
      trial->entropy_nat > before_nat + kMostGain_nat ||
      (is_sharper(trial->entropy_nat, before_nat) && !covers_drive(*trial, rigid));
  if (rounds < kRounds && !is_clear) {
    const Drive middle = middle_of(trial->timed, rigid.trajectory);
    SIGHTLINE_ASSIGN(trial, continued(ctx, middle, *trial, estimate, kRounds - rounds));
  }
  if (trial && !is_sharper(trial->entropy_nat, before_nat)) trial.reset();
  return trial;
}

}  // namespace

Result<Estimate> estimate_undistorted(PassContext& ctx, const Drive& drive, const Estimate& rigid,
                                      const EstimatePoses& estimate) {
  PassContext without_warnings = quiet(ctx);
  const std::vector<Drive> parts = parts_of(drive);
  const std::vector<Trajectory> rigid_parts = trajectories_of_parts(parts, rigid.trajectory);
  std::vector<Measured> measured;
  bool are_rigid = true;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    measured.push_back({parts[i], std::nullopt});
    SIGHTLINE_ASSIGN(std::optional<Trial> trial,
                     best_deskew_trial(without_warnings, parts[i], {rigid_parts[i], {}}, estimate));
    if (!trial) continue;
    if (covers_drive(*trial, rigid)) return std::move(trial->of_middle);
    measured.back().timed = std::move(trial->timed);
    are_rigid = false;
  }
  if (are_rigid) return rigid;
  return estimate_as_measured(without_warnings, drive, measured, rigid, estimate, kRounds);
}

}  // namespace sightline
