#include "passes/trajectory/given/motion_drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

constexpr double kWindow_m = 3.0;
constexpr std::uint32_t kMostSteps = 20;
constexpr double kArm_m = 10.0;  // a turn counts as what it moves surfaces at this distance

// Whether the scans show the step to scan k.
bool is_shown(const GivenPoses& given, const Odometry& odometry, std::uint32_t k) {
  const StepConstraint& step = odometry.constraint[k];
  return given[k - 1] && given[k] && odometry.is_matched[k] && !odometry.is_far[k] &&
         odometry.piece[k - 1] == odometry.piece[k] && step.forecast == Forecast::kNone &&
         step.weak.isZero();
}

// Motions over about 3 m; the next one begins a scan later, or where the last one ended.
enum class Next { kEachScan, kAtEnd };
std::vector<MotionPair> shown_motions(const GivenPoses& given, const Odometry& odometry,
                                      Next next) {
  std::vector<MotionPair> motions;
  const auto count = static_cast<std::uint32_t>(given.size());
  for (std::uint32_t first = 0; first + 1 < count;) {
    std::uint32_t last = first;
    const auto way_m = [&] { return odometry.driven_m[last] - odometry.driven_m[first]; };
    while (last + 1 < count && last - first < kMostSteps && way_m() < kWindow_m &&
           is_shown(given, odometry, last + 1)) {
      ++last;
    }
    const bool is_long = way_m() >= kWindow_m;
    if (is_long) motions.push_back(motion_between(given, odometry, first, last));
    first = is_long && next == Next::kAtEnd ? last : first + 1;
  }
  return motions;
}

double off_m(const Pose& given, const Pose& matched) {
  const double off_rad = rotation_angle_rad(matched.linear().transpose() * given.linear());
  return portable_hypot((given.translation() - matched.translation()).norm(), kArm_m * off_rad);
}

// Poses of scans, read at any time between them.
class TimedPoses {
 public:
  explicit TimedPoses(const Drive& drive) : scans_(drive.scans) {}

  [[nodiscard]] std::optional<Pose> at(std::int64_t stamp_ns) const {
    constexpr std::int64_t kLongestGap_ns = 3 * kSecond_ns / 2;
    const auto after = std::ranges::lower_bound(scans_, stamp_ns, {}, &ScanInfo::stamp_ns);
    if (after == scans_.end()) return std::nullopt;
    if (after->stamp_ns == stamp_ns) return after->T_world_vehicle;
    if (after == scans_.begin()) return std::nullopt;
    const ScanInfo& before = *std::prev(after);
    const std::int64_t gap_ns = after->stamp_ns - before.stamp_ns;
    if (gap_ns > kLongestGap_ns || !before.T_world_vehicle || !after->T_world_vehicle) {
      return std::nullopt;
    }
    return interpolate(
        *before.T_world_vehicle, *after->T_world_vehicle,
        static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(gap_ns));
  }

 private:
  const std::vector<ScanInfo>& scans_;
};

// Differences of motions, m, with poses read at a later time; NaN where there is no pose then.
class ShiftTrial {
 public:
  ShiftTrial(const Drive& drive, const std::vector<MotionPair>& motions)
      : drive_(drive), motions_(motions), poses_(drive) {}

  [[nodiscard]] std::vector<double> offs_m(std::int64_t shift_ns) const {
    const Pose& T_vehicle_lidar = drive_.sensor.T_vehicle_lidar;
    std::vector<double> offs;
    for (const MotionPair& motion : motions_) {
      const auto from = poses_.at(drive_.scans[motion.from].stamp_ns + shift_ns);
      const auto to = poses_.at(drive_.scans[motion.to].stamp_ns + shift_ns);
      offs.push_back(
          from && to ? off_m(T_vehicle_lidar.inverse() * from->inverse() * *to * T_vehicle_lidar,
                             motion.matched)
                     : std::nan(""));
    }
    return offs;
  }

 private:
  const Drive& drive_;
  const std::vector<MotionPair>& motions_;
  TimedPoses poses_;
};

// Mean squares over the motions that both have, with a limit for slips of the matching.
struct Costs {
  std::size_t count = 0;
  std::size_t explained = 0;  // motions that differ as given, and hardly with the shift
  double given_m2 = 0.0;
  double shifted_m2 = 0.0;
};

double square(double value) { return value * value; }

Costs costs_of(const std::vector<double>& given_m, const std::vector<double>& shifted_m) {
  constexpr double kMost_m = 0.5;
  constexpr double kDiffers_m = 0.1;
  Costs costs;
  for (std::size_t i = 0; i < given_m.size(); ++i) {
    if (std::isnan(given_m[i]) || std::isnan(shifted_m[i])) continue;
    ++costs.count;
    costs.explained += given_m[i] > kDiffers_m && shifted_m[i] < 0.5 * given_m[i] ? 1 : 0;
    costs.given_m2 += square(std::min(given_m[i], kMost_m));
    costs.shifted_m2 += square(std::min(shifted_m[i], kMost_m));
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, costs.count));
  costs.given_m2 /= count;
  costs.shifted_m2 /= count;
  return costs;
}

constexpr std::int64_t kMillisecond_ns = kSecond_ns / 1000;
constexpr std::int64_t kFarthest_ns = kSecond_ns;

// The shift with the least share of the cost as given, in steps around `middle_ns`.
std::int64_t best_shift_ns(const ShiftTrial& trial, std::int64_t middle_ns, std::int64_t reach_ns,
                           std::int64_t step_ns) {
  const std::vector<double> given_m = trial.offs_m(0);
  std::int64_t best_ns = 0;
  double least = 1.0;
  for (std::int64_t shift_ns = middle_ns - reach_ns; shift_ns <= middle_ns + reach_ns;
       shift_ns += step_ns) {
    const Costs costs = costs_of(given_m, trial.offs_m(shift_ns));
    if (2 * costs.count < given_m.size() || costs.given_m2 == 0.0) continue;
    const double share = costs.shifted_m2 / costs.given_m2;
    if (share >= least) continue;
    least = share;
    best_ns = shift_ns;
  }
  return best_ns;
}

// A shift that is nearly a whole number of scans is one: poses of other scans.
std::int64_t whole_scans(const Drive& drive, std::int64_t shift_ns) {
  constexpr std::int64_t kNear_ns = 15 * kMillisecond_ns;
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::ranges::nth_element(steps_ns, middle);
  if (*middle <= 2 * kNear_ns) return shift_ns;
  const std::int64_t whole_ns =
      *middle * static_cast<std::int64_t>(
                    std::llround(static_cast<double>(shift_ns) / static_cast<double>(*middle)));
  return std::abs(whole_ns - shift_ns) <= kNear_ns ? whole_ns : shift_ns;
}

// In level axes of the sensor before the motion: how much farther ahead, to the left and round the
// given motion leads.
Eigen::Vector3d difference(const MotionPair& motion) {
  const Eigen::Vector3d way_m = motion.matched.translation();
  const double ahead_m = portable_hypot(way_m.x(), way_m.y());
  if (ahead_m == 0.0) return Eigen::Vector3d::Zero();
  const Eigen::Vector2d ahead = way_m.head<2>() / ahead_m;
  const Eigen::Vector3d off_m = motion.given.translation() - way_m;
  const Eigen::Matrix3d turn = motion.matched.linear().transpose() * motion.given.linear();
  return {ahead.dot(off_m.head<2>()), ahead.x() * off_m.y() - ahead.y() * off_m.x(),
          portable_atan2(turn(1, 0), turn(0, 0))};
}

double length_m(const MotionPair& motion) { return motion.matched.translation().norm(); }

// Sum of a value over the motions, as if those that differ most were as the others.
double trimmed_sum(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t cut = values.size() / 8;
  double sum = 0.0;
  for (std::size_t i = cut; i + cut < values.size(); ++i) sum += values[i];
  return sum * static_cast<double>(values.size()) / static_cast<double>(values.size() - 2 * cut);
}

MotionDrift drift_of(std::span<const MotionPair> motions) {
  MotionDrift drift{motions.front().from, motions.back().to};
  std::vector<double> along, aside, turn;
  for (const MotionPair& motion : motions) {
    const Eigen::Vector3d off = difference(motion);
    along.push_back(off[0]);
    aside.push_back(off[1]);
    turn.push_back(off[2]);
    drift.way_m += length_m(motion);
  }
  drift.along_m = trimmed_sum(along);
  drift.aside_m = trimmed_sum(aside);
  drift.turn_rad = trimmed_sum(turn);
  return drift;
}

constexpr double kStretch_m = 100.0;

}  // namespace

std::optional<ClockShift> find_clock_shift(const Drive& drive, const GivenPoses& given,
                                           const Odometry& odometry) {
  constexpr std::size_t kFewestMotions = 20;
  constexpr std::size_t kFewestExplained = 5;
  constexpr double kExplains = 0.3;
  constexpr std::int64_t kLeast_ns = 80 * kMillisecond_ns;
  if (!drive.later_parts.empty() || !drive.has_poses()) return std::nullopt;
  const std::vector<MotionPair> motions = shown_motions(given, odometry, Next::kEachScan);
  if (motions.size() < kFewestMotions) return std::nullopt;
  const ShiftTrial trial(drive, motions);
  const std::int64_t coarse_ns = best_shift_ns(trial, 0, kFarthest_ns, 50 * kMillisecond_ns);
  const std::int64_t fine_ns =
      best_shift_ns(trial, coarse_ns, 50 * kMillisecond_ns, 5 * kMillisecond_ns);
  if (std::abs(fine_ns) < kLeast_ns || std::abs(fine_ns) >= kFarthest_ns) return std::nullopt;
  const std::int64_t shift_ns = whole_scans(drive, fine_ns);
  const Costs costs = costs_of(trial.offs_m(0), trial.offs_m(shift_ns));
  if (costs.explained < kFewestExplained || costs.shifted_m2 > kExplains * costs.given_m2) {
    return std::nullopt;
  }
  return ClockShift{shift_ns, std::sqrt(costs.given_m2), std::sqrt(costs.shifted_m2)};
}

Drive with_clock(Drive drive, const ClockShift& shift, const Odometry& odometry) {
  const TimedPoses poses(drive);
  std::vector<std::optional<Pose>> moved;
  for (const ScanInfo& scan : drive.scans) {
    moved.push_back(poses.at(scan.stamp_ns + shift.ahead_ns));
  }
  const Pose& T_vehicle_lidar = drive.sensor.T_vehicle_lidar;
  const auto follow = [&](std::size_t from, std::size_t to) {
    if (!moved[from] || moved[to]) return;
    moved[to] = *moved[from] * T_vehicle_lidar * odometry.T_map_lidar[from].inverse() *
                odometry.T_map_lidar[to] * T_vehicle_lidar.inverse();
  };
  for (std::size_t i = 1; i < moved.size(); ++i) follow(i - 1, i);
  for (std::size_t i = moved.size() - 1; i > 0; --i) follow(i, i - 1);
  for (std::size_t i = 0; i < moved.size(); ++i) drive.scans[i].T_world_vehicle = moved[i];
  return drive;
}

std::string to_text(const ClockShift& shift, const Drive& drive) {
  return fmt::format(
      "the clock of the given poses of drive {} is {:.2f} s {} that of the scans: over 3 m they "
      "move {:.2f} m otherwise than the scans, with poses of that clock {:.2f} m",
      drive.name, std::abs(static_cast<double>(shift.ahead_ns) / static_cast<double>(kSecond_ns)),
      shift.ahead_ns > 0 ? "ahead of" : "behind", shift.off_m, shift.corrected_off_m);
}

std::vector<MotionDrift> find_drifts(const JumpLimits& limits, const GivenPoses& given,
                                     const Odometry& odometry) {
  constexpr double kShare = 0.02;
  const std::vector<MotionPair> motions = shown_motions(given, odometry, Next::kAtEnd);
  std::vector<MotionDrift> drifts;
  double way_m = 0.0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    way_m += length_m(motions[i]);
    if (way_m < kStretch_m) continue;
    const MotionDrift drift = drift_of(std::span(motions).subspan(first, i + 1 - first));
    if (portable_hypot(drift.along_m, drift.aside_m) > limits.off_m + kShare * drift.way_m ||
        std::abs(drift.turn_rad) > limits.off_rad) {
      drifts.push_back(drift);
    }
    first = i + 1;
    way_m = 0.0;
  }
  return drifts;
}

std::string to_text(const MotionDrift& drift, const Drive& drive) {
  return fmt::format(
      "scans {} to {}: over {:.0f} m the given poses lead {:.1f} m farther ahead, {:.1f} m farther "
      "to the left and {:.1f} degrees farther round than the scans",
      drive.scans[drift.first].recording_index, drive.scans[drift.last].recording_index,
      drift.way_m, drift.along_m, drift.aside_m, drift.turn_rad * 180.0 / std::numbers::pi);
}

std::optional<double> find_scale_error(const GivenPoses& given, const Odometry& odometry) {
  constexpr double kLeast = 0.007;
  constexpr std::size_t kParts = 4;
  const std::vector<MotionPair> motions = shown_motions(given, odometry, Next::kAtEnd);
  if (motions.size() < kParts) return std::nullopt;
  const MotionDrift whole = drift_of(motions);
  const double error = whole.along_m / whole.way_m;
  if (whole.way_m < kStretch_m || std::abs(error) < kLeast) return std::nullopt;
  for (std::size_t part = 0; part < kParts; ++part) {
    const std::size_t begin = part * motions.size() / kParts;
    const std::size_t end = (part + 1) * motions.size() / kParts;
    const MotionDrift drift = drift_of(std::span(motions).subspan(begin, end - begin));
    if (drift.along_m / drift.way_m / error < 0.5) return std::nullopt;
  }
  return error;
}

}  // namespace sightline
