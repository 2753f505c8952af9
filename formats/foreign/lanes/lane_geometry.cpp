#include "formats/foreign/lanes/lane_geometry.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "formats/base/check.h"

namespace sightline {

LineByShare::LineByShare(std::vector<Eigen::Vector3d> points_m) : points_m_(std::move(points_m)) {
  SIGHTLINE_CHECK(!points_m_.empty());
  until_m_.push_back(0.0);
  for (std::size_t i = 1; i < points_m_.size(); ++i) {
    until_m_.push_back(until_m_.back() + (points_m_[i] - points_m_[i - 1]).head<2>().norm());
  }
}

LineByShare::Place LineByShare::place(double share) const {
  if (share >= 1.0 || points_m_.size() == 1) {
    return points_m_.size() == 1 ? Place{} : Place{points_m_.size() - 2, 1.0};
  }
  const double at_m = share * length_m();
  const auto after = std::upper_bound(until_m_.begin() + 1, until_m_.end() - 1, at_m);
  const auto segment = static_cast<std::size_t>(after - until_m_.begin()) - 1;
  const double step_m = until_m_[segment + 1] - until_m_[segment];
  return {segment, step_m > 0.0 ? (at_m - until_m_[segment]) / step_m : 0.0};
}

Eigen::Vector3d LineByShare::at(double share) const {
  const Place found = place(share);
  if (found.within == 0.0) return points_m_[found.segment];
  if (found.within == 1.0) return points_m_[found.segment + 1];
  const Eigen::Vector3d step_m = points_m_[found.segment + 1] - points_m_[found.segment];
  return points_m_[found.segment] + found.within * step_m;
}

double left_of(const std::vector<Eigen::Vector3d>& line_m, const Eigen::Vector3d& p_m) {
  double nearest_m = std::numeric_limits<double>::infinity();
  double side = 0.0;
  for (std::size_t i = 1; i < line_m.size(); ++i) {
    const Eigen::Vector2d along_m = (line_m[i] - line_m[i - 1]).head<2>();
    const Eigen::Vector2d to_m = (p_m - line_m[i - 1]).head<2>();
    const double squared = along_m.squaredNorm();
    if (squared == 0.0) continue;
    const double share = std::clamp(to_m.dot(along_m) / squared, 0.0, 1.0);
    const double distance_m = (to_m - share * along_m).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    side = along_m.x() * to_m.y() - along_m.y() * to_m.x();
  }
  return side;
}

std::vector<Eigen::Vector3d> middle_of(const LineByShare& left, const LineByShare& right,
                                       std::size_t steps) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double share = steps == 0 ? 0.0 : static_cast<double>(i) / static_cast<double>(steps);
    points_m.emplace_back(0.5 * (left.at(share) + right.at(share)));
  }
  return points_m;
}

}  // namespace sightline
