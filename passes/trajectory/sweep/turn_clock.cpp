#include "passes/trajectory/sweep/turn_clock.h"

#include <algorithm>
#include <cstddef>

#include "formats/geometry.h"

// The mean of the rates over an interval is the difference of their integral at its ends, so one
// pass over the rates serves all clocks. A constant error of the rates shifts all means alike and
// is removed with their mean.

namespace sightline {
namespace {

constexpr std::int64_t kFarthest_ns = 500'000'000;
constexpr std::int64_t kStep_ns = 5'000'000;
constexpr std::int64_t kLongestInterval_ns = 500'000'000;
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
    if (from.piece != to.piece || duration_ns <= 0 || duration_ns > kLongestInterval_ns) continue;
    if (!integral.covers(from.stamp_ns - kFarthest_ns, to.stamp_ns + kFarthest_ns)) continue;
    const Eigen::Vector3d turn_rad =
        rotation_vector(from.T_map_vehicle.linear().transpose() * to.T_map_vehicle.linear());
    intervals.push_back({from.stamp_ns, to.stamp_ns, turn_rad / seconds(duration_ns)});
  }
  return intervals;
}

// Keeps enough intervals, evenly over the drive.
void keep_some(std::vector<Interval>& intervals) {
  const std::size_t step = (intervals.size() + kMostIntervals - 1) / kMostIntervals;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < intervals.size(); i += step) intervals[kept++] = intervals[i];
  intervals.resize(kept);
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

TurnClock turn_clock(const Trajectory& trajectory, std::span<const TurnRate> rates) {
  TurnClock clock;
  const Integral integral(rates);
  std::vector<Interval> intervals = intervals_of(trajectory, integral);
  if (intervals.size() < kLeastIntervals) return clock;
  keep_some(intervals);
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
