#include "passes/trajectory/graph/height_errors.h"

#include <algorithm>
#include <cmath>

namespace sightline {

HeightErrors::HeightErrors(std::span<const GraphEdge> steps, std::span<const Pose> T_map_lidar)
    : sums_(T_map_lidar.size()) {
  for (const Pose& pose : T_map_lidar) places_m_.push_back(pose.translation().head<2>());
  std::size_t next = 0;
  for (std::size_t k = 1; k < sums_.size(); ++k) {
    Sums& sums = sums_[k] = sums_[k - 1];
    while (next < steps.size() && steps[next].to < k) ++next;
    if (next == steps.size() || steps[next].to != k) continue;
    const GraphEdge& step = steps[next];
    const double turn_rad2 = step.sigma_rad * step.sigma_rad;
    sums.height_m2 += step.sigma_m * step.sigma_m;
    sums.turn_rad2 += turn_rad2;
    sums.moment += turn_rad2 * places_m_[k];
    sums.second_moment += turn_rad2 * places_m_[k].squaredNorm();
  }
}

double HeightErrors::sigma_m(std::size_t earlier, std::size_t later) const {
  const Sums& from = sums_[earlier];
  const Sums& to = sums_[later];
  const Eigen::Vector2d& place_m = places_m_[later];
  const double by_turns_m2 = to.second_moment - from.second_moment -
                             2.0 * place_m.dot(to.moment - from.moment) +
                             place_m.squaredNorm() * (to.turn_rad2 - from.turn_rad2);
  return std::sqrt(std::max(0.0, to.height_m2 - from.height_m2 + by_turns_m2));
}

}  // namespace sightline
