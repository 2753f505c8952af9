#include "passes/trajectory/sweep/turn_trial.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "formats/geometry.h"
#include "formats/text/table.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/turn_curve.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

constexpr std::size_t kTrialScans = 60;
constexpr std::int64_t kLongestInterval_ns = 1'500'000'000;
// A turn that moves what is 50 m away by less than half a centimetre.
constexpr double kLeastBend_rad = 1e-4;
// A clock is known to this from poses ten times a second.
constexpr std::int64_t kLeastAhead_ns = 10'000'000;
// Another clock must explain so much of the turning that the old one does not.
constexpr double kLeastShareExplained = 0.2;
// Right rates gain 0.02 nat and more where poses are off by 1 cm and 0.05 degrees, and wrong ones
// lose 0.05.
constexpr double kSharper_nat = 0.005;

// Of each scan of the first sensor: how far the rates bend the turning to its next one from an even
// one. Of scans of other sensors 0.
std::vector<double> bends_rad(const Drive& drive, const Trajectory& trajectory) {
  std::vector<double> bends(trajectory.poses.size(), 0.0);
  const TrajectoryPose* from = nullptr;
  std::size_t of_scan = 0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    if (drive.scans[i].sensor_index != 0) continue;
    const TrajectoryPose& to = trajectory.poses[i];
    const bool is_step =
        from && from->piece == to.piece && to.stamp_ns - from->stamp_ns <= kLongestInterval_ns;
    if (is_step) {
      const std::optional<TurnCurve> curve = TurnCurve::between(
          drive.turn_rates,
          {from->stamp_ns, to.stamp_ns, from->T_map_vehicle.linear(), to.T_map_vehicle.linear()});
      if (curve) bends[of_scan] = curve->bend_rad();
    }
    from = &to;
    of_scan = i;
  }
  return bends;
}

struct Stretch {
  std::size_t first = 0;
  std::size_t count = 0;
  double bend_rad = 0.0;  // mean
};

// The scans in a row that bend most.
Stretch most_bent(const std::vector<double>& bends) {
  Stretch most;
  for (std::size_t end = 1; end <= bends.size(); ++end) {
    const std::size_t first = end > kTrialScans ? end - kTrialScans : 0;
    double sum_rad = 0.0;
    for (std::size_t i = first; i < end; ++i) sum_rad += bends[i];
    const double mean_rad = sum_rad / static_cast<double>(kTrialScans);
    if (mean_rad > most.bend_rad) most = {first, end - first, mean_rad};
  }
  return most;
}

Result<double> entropy_nat(PassContext& ctx, const Drive& drive, const Trajectory& trajectory,
                           const Stretch& stretch) {
  const Drive straight = stretch_of(undistorted(drive, trajectory), stretch.first, stretch.count);
  const Trajectory part = stretch_of(trajectory, stretch.first, stretch.count);
  SIGHTLINE_ASSIGN(const Sharpness sharpness, measure_sharpness(ctx, {}, straight, part));
  return sharpness.of_map.mean_entropy_nat;
}

// How far the clock is ahead; 0 where another one does not explain clearly more.
std::int64_t ahead_ns(const TurnClock& clock) {
  const double unexplained = 1.0 - clock.explained_as_is;
  const bool is_clear =
      clock.explained_moved - clock.explained_as_is > kLeastShareExplained * unexplained;
  const bool is_far = std::abs(clock.ahead_ns) >= kLeastAhead_ns;
  return clock.is_known && is_clear && is_far && clock.explained_moved > 0.5 ? clock.ahead_ns : 0;
}

std::string thousandths(double value) { return format_double(std::round(value * 1e3) / 1e3); }

// Of clocks that are compared. The mean of the rates over an interval is the difference of their
// integral at its ends, so one pass over the rates serves all clocks. A constant error of the rates
// shifts all means alike and is removed with their mean.
constexpr std::int64_t kFarthest_ns = 500'000'000;
constexpr std::int64_t kStep_ns = 5'000'000;
constexpr std::int64_t kLongestClocked_ns = 500'000'000;
constexpr std::int64_t kLongestGap_ns = 50'000'000;
constexpr std::size_t kLeastIntervals = 20;
constexpr std::size_t kMostIntervals = 4000;  // each is compared by 201 clocks
// Root mean square about the mean; errors of 0.05 degrees in poses look like turning by 0.01 rad/s.
constexpr double kLeastTurning_radps = 0.03;

double seconds(std::int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

// The integral of the rates, axis by axis, from the first of them on.
class Integral {
 public:
  explicit Integral(std::span<const TurnRate> rates) : rates_(rates) {
    sums_rad_.resize(rates.size(), Eigen::Vector3d::Zero());
    gaps_.resize(rates.size(), 0);
    for (std::size_t i = 1; i < rates.size(); ++i) {
      const std::int64_t step_ns = rates[i].stamp_ns - rates[i - 1].stamp_ns;
      sums_rad_[i] = sums_rad_[i - 1] + 0.5 * seconds(step_ns) *
                                            (rates[i].rate_rad_per_s + rates[i - 1].rate_rad_per_s);
      gaps_[i] = gaps_[i - 1] + (step_ns > kLongestGap_ns ? 1 : 0);
    }
  }

  // Whether rates without a gap cover the time.
  [[nodiscard]] bool covers(std::int64_t from_ns, std::int64_t to_ns) const {
    if (rates_.size() < 2) return false;
    if (from_ns < rates_.front().stamp_ns || to_ns > rates_.back().stamp_ns) return false;
    const std::size_t last = std::min(step_at(to_ns) + 1, rates_.size() - 1);
    return gaps_[last] == gaps_[step_at(from_ns)];
  }

  // At a time that is covered.
  [[nodiscard]] Eigen::Vector3d at(std::int64_t time_ns) const {
    const std::size_t i = std::min(step_at(time_ns), rates_.size() - 2);
    const TurnRate& from = rates_[i];
    const TurnRate& to = rates_[i + 1];
    const double share = static_cast<double>(time_ns - from.stamp_ns) /
                         static_cast<double>(to.stamp_ns - from.stamp_ns);
    const Eigen::Vector3d mean =
        from.rate_rad_per_s + 0.5 * share * (to.rate_rad_per_s - from.rate_rad_per_s);
    return sums_rad_[i] + seconds(time_ns - from.stamp_ns) * mean;
  }

 private:
  // The last rate at or before a time that is not before the first.
  [[nodiscard]] std::size_t step_at(std::int64_t time_ns) const {
    const auto behind = std::ranges::upper_bound(rates_, time_ns, {}, &TurnRate::stamp_ns);
    return static_cast<std::size_t>(behind - rates_.begin()) - 1;
  }

  std::span<const TurnRate> rates_;
  std::vector<Eigen::Vector3d> sums_rad_;
  std::vector<std::size_t> gaps_;  // up to each rate
};

// The turning between two poses.
struct Interval {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
};

// The intervals that the rates cover by every clock.
std::vector<Interval> intervals_of(const Trajectory& trajectory, const Integral& integral) {
  std::vector<Interval> intervals;
  for (std::size_t i = 1; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& from = trajectory.poses[i - 1];
    const TrajectoryPose& to = trajectory.poses[i];
    const std::int64_t duration_ns = to.stamp_ns - from.stamp_ns;
    if (from.piece != to.piece || duration_ns <= 0 || duration_ns > kLongestClocked_ns) continue;
    if (!integral.covers(from.stamp_ns - kFarthest_ns, to.stamp_ns + kFarthest_ns)) continue;
    const Eigen::Vector3d turn_rad =
        rotation_vector(from.T_map_vehicle.linear().transpose() * to.T_map_vehicle.linear());
    intervals.push_back({from.stamp_ns, to.stamp_ns, turn_rad / seconds(duration_ns)});
  }
  return intervals;
}

// Of vectors about their mean, by their number.
double spread(const std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& value : values) mean += value;
  mean /= static_cast<double>(values.size());
  double sum = 0.0;
  for (const Eigen::Vector3d& value : values) sum += (value - mean).squaredNorm();
  return sum / static_cast<double>(values.size());
}

// The variance of the poses' turning that the rates do not explain, with their clock so far ahead.
double unexplained(const std::vector<Interval>& intervals, const Integral& integral,
                   std::int64_t ahead_ns) {
  std::vector<Eigen::Vector3d> differences;
  differences.reserve(intervals.size());
  for (const Interval& interval : intervals) {
    const Eigen::Vector3d turn_rad =
        integral.at(interval.to_ns + ahead_ns) - integral.at(interval.from_ns + ahead_ns);
    differences.emplace_back(turn_rad / seconds(interval.to_ns - interval.from_ns) -
                             interval.rate_radps);
  }
  return spread(differences);
}

}  // namespace

Drive without_turns(Drive drive) {
  drive.turn_rates.clear();
  return drive;
}

Result<Drive> with_imu_if_sharper(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory) {
  if (drive.turn_rates.empty()) return drive;
  const std::string name = concat("drive ", drive.name, ": ");
  Drive turned = drive;
  const TurnClock clock = turn_clock(poses_of_first_sensor(drive, trajectory), drive.turn_rates);
  const std::int64_t moved_ns = ahead_ns(clock);
  if (moved_ns != 0) {
    turned.turn_rates = moved_by(drive.turn_rates, moved_ns);
    ctx.warn(
        concat(name, "the clock of the turn rates is ",
               thousandths(1e-9 * static_cast<double>(std::abs(moved_ns))), " s ",
               (moved_ns > 0 ? "ahead of" : "behind"),
               " that of the scans, found from the turning of the poses; the rates are shifted"));
  }
  const Stretch stretch = most_bent(bends_rad(turned, trajectory));
  if (stretch.bend_rad < kLeastBend_rad) {
    ctx.warn(
        name +
        "turn rates are not used: they cover no scans, or the vehicle turned at a constant rate");
    return without_turns(drive);
  }
  const Drive even = without_turns(drive);
  SIGHTLINE_ASSIGN(const double even_nat, entropy_nat(ctx, even, trajectory, stretch));
  SIGHTLINE_ASSIGN(const double turned_nat, entropy_nat(ctx, turned, trajectory, stretch));
  const bool is_sharper = turned_nat < even_nat - kSharper_nat;
  ctx.inform(concat(name, "turn rates are ", (is_sharper ? "used" : "not used"),
                    ": where they change most, the mean map entropy is ", thousandths(turned_nat),
                    " nat with them and ", thousandths(even_nat), " nat without"));
  return is_sharper ? turned : even;
}

TurnClock turn_clock(const Trajectory& trajectory, std::span<const TurnRate> rates) {
  TurnClock clock;
  const Integral integral(rates);
  const std::vector<Interval> all = intervals_of(trajectory, integral);
  if (all.size() < kLeastIntervals) return clock;
  std::vector<Interval> intervals;  // enough, evenly over the drive
  const std::size_t step = (all.size() + kMostIntervals - 1) / kMostIntervals;
  for (std::size_t i = 0; i < all.size(); i += step) intervals.push_back(all[i]);
  std::vector<Eigen::Vector3d> measured;
  for (const Interval& interval : intervals) measured.push_back(interval.rate_radps);
  const double turning = spread(measured);
  if (turning < kLeastTurning_radps * kLeastTurning_radps) return clock;
  clock.is_known = true;
  const double as_is = unexplained(intervals, integral, 0);
  double least = as_is;
  for (std::int64_t ahead_ns = -kFarthest_ns; ahead_ns <= kFarthest_ns; ahead_ns += kStep_ns) {
    const double left = unexplained(intervals, integral, ahead_ns);
    if (left >= least) continue;
    least = left;
    clock.ahead_ns = ahead_ns;
  }
  clock.explained_as_is = 1.0 - as_is / turning;
  clock.explained_moved = 1.0 - least / turning;
  return clock;
}

std::vector<TurnRate> moved_by(std::span<const TurnRate> rates, std::int64_t ahead_ns) {
  std::vector<TurnRate> moved(rates.begin(), rates.end());
  for (TurnRate& rate : moved) rate.stamp_ns -= ahead_ns;
  return moved;
}

}  // namespace sightline
