#include "passes/matching/look_test.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "formats/geometry.h"
#include "passes/matching/horizontal_curvature.h"

namespace sightline {
namespace {

// A match differs by so much from its prediction in any case, and no direction is looser.
constexpr double kLeastMotion_m = 0.01;
constexpr double kLeastTurn_rad = 0.001;
constexpr double kLeastCurvature_per_m2 = 0.1;

}  // namespace

LookSigns look_signs(const MatchResult& match, std::size_t point_count,
                     const Pose& T_map_predicted) {
  const double count = static_cast<double>(std::max<std::size_t>(point_count, 1));
  const double scored = std::max(1.0, static_cast<double>(match.scored_points));
  const HorizontalCurvature curvature = horizontal_curvature(match.hessian);
  const auto log_sigma = [](double curvature_per_m2) {
    return -0.5 * portable_log(std::max(curvature_per_m2, kLeastCurvature_per_m2));
  };
  const Eigen::Vector3d moved_m = match.T_map_sensor.translation() - T_map_predicted.translation();
  const double along_m = std::abs(curvature.weak_direction.dot(moved_m.head<2>()));
  const double across_m = std::sqrt(std::max(0.0, moved_m.squaredNorm() - along_m * along_m));
  const Eigen::Matrix3d turn = T_map_predicted.linear().transpose() * match.T_map_sensor.linear();
  return {log_sigma(curvature.weak),
          log_sigma(curvature.strong),
          static_cast<double>(match.scored_points) / count,
          match.score / scored,
          match.nearest_voxel_likelihood,
          portable_log(along_m + kLeastMotion_m),
          portable_log(across_m + kLeastMotion_m),
          portable_log(rotation_angle_rad(turn) + kLeastTurn_rad)};
}

}  // namespace sightline
