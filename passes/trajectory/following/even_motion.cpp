#include "passes/trajectory/following/even_motion.h"

#include <algorithm>

#include "formats/base/units.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

// How far from the predicted pose a scan is searched for: at the start, when the speed is not
// known, and where matching failed.
constexpr double kSearchReach_m = 3.0;

constexpr std::int64_t kShortestJump_ns = kSecond_ns;
// Even motion is extended to at most so many times the step that it was measured on.
constexpr double kMostSteps = 10.0;
constexpr double kNewShare = 0.1;
constexpr double kUsual = 0.85;

// Poses of a vehicle that turns or brakes harder than at constant velocity.
std::vector<Pose> bolder(const Pose& T_map_before, const Pose& T_map_start) {
  std::vector<Pose> starts;
  const Pose step = T_map_before.inverse() * T_map_start;
  for (const double turn_rad : {-0.12, -0.06, 0.06, 0.12}) {
    Pose start = T_map_start;
    start.linear() = T_map_start.linear() * rotation_matrix({Eigen::Vector3d::UnitZ(), turn_rad});
    starts.push_back(start);
  }
  for (const double share : {0.0, 0.5, 1.5}) {
    Pose part = step;
    part.translation() *= share;
    starts.push_back(T_map_before * part);
  }
  return starts;
}

// The best of `best` and the matches from these starts.
LocalMatch best_of(LocalSearch& search, const std::vector<Pose>& starts, LocalMatch best) {
  for (const Pose& start : starts) {
    const std::optional<LocalMatch> match = search.match(start);
    if (match && match->is_better_than(best)) best = *match;
  }
  return best;
}

}  // namespace

std::int64_t longest_step_ns(const Drive& drive) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  if (steps_ns.empty()) return kShortestJump_ns;
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::ranges::nth_element(steps_ns, middle);
  return std::max(kShortestJump_ns, 3 * *middle);
}

Pose carried_on(const TimedStep& step, std::int64_t time_ns) {
  if (step.time_ns <= 0 || time_ns == step.time_ns) return step.T_before_after;
  const double share =
      std::clamp(static_cast<double>(time_ns) / static_cast<double>(step.time_ns), 0.0, kMostSteps);
  const AxisAngle turn = axis_angle(step.T_before_after.linear());
  const Eigen::Matrix3d half_more =
      rotation_matrix({turn.axis, 0.5 * (share - 1.0) * turn.angle_rad});
  Pose longer = Pose::Identity();
  longer.linear() = rotation_matrix({turn.axis, share * turn.angle_rad});
  longer.translation() = share * (half_more * step.T_before_after.translation());
  return longer;
}

void RunningAverage::add(const LocalMatch& match, std::optional<double> scan_overlap) {
  if (likelihood == 0.0) *this = {match.likelihood, match.scored_share, 0.0};
  likelihood += kNewShare * (match.likelihood - likelihood);
  scored_share += kNewShare * (match.scored_share - scored_share);
  if (!scan_overlap) return;
  if (overlap == 0.0) overlap = *scan_overlap;
  overlap += kNewShare * (*scan_overlap - overlap);
}

bool RunningAverage::is_met_by(const LocalMatch& match) const {
  return match.likelihood >= kUsual * likelihood && match.scored_share >= kUsual * scored_share;
}

LocalMatch follow(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                  const std::vector<Pose>& starts, const Pose& T_map_before,
                  const RunningAverage& average) {
  LocalSearch search(grids, points_m);
  LocalMatch best = best_of(search, starts, {});
  if (!average.is_met_by(best)) {
    best = best_of(search, bolder(T_map_before, starts.front()), best);
  }
  const bool is_first = average.likelihood == 0.0;
  if (is_first || !best.is_good()) {
    for (const Pose& start : starts) {
      best = best_of(search, starts_around(start, kSearchReach_m), best);
    }
  }
  return best;
}

}  // namespace sightline
