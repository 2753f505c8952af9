#include "passes/trajectory/local/surface_between.h"

#include <algorithm>

namespace sightline {

bool is_surface_between(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& a_m,
                        const Eigen::Vector3d& b_m) {
  constexpr double kBeside_m = 0.3;
  constexpr double kEnd_m = 0.3;
  constexpr std::ptrdiff_t kLeastPoints = 5;
  const double length_m = (b_m - a_m).norm();
  if (length_m <= 2.0 * kEnd_m) return false;
  const Eigen::Vector3d ahead = (b_m - a_m) / length_m;
  const auto is_on_line = [&](const Eigen::Vector3d& point_m) {
    const Eigen::Vector3d offset_m = point_m - a_m;
    const double along_m = offset_m.dot(ahead);
    return along_m > kEnd_m && along_m < length_m - kEnd_m &&
           (offset_m - along_m * ahead).squaredNorm() < kBeside_m * kBeside_m;
  };
  return std::ranges::count_if(points_m, is_on_line) >= kLeastPoints;
}

}  // namespace sightline
