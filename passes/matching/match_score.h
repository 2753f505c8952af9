#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "formats/geometry.h"
#include "passes/matching/grid/match_grid.h"

namespace sightline {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The NDT score of a scan at one pose, and its derivatives by a small motion of the pose:
// x -> t + dt + exp([w]x) R q, with dt the first three and w the last three, in map axes.
struct MatchScore {
  double score = 0.0;  // sum of -d1 exp(-d2/2 m^2) over points and NDs of own cell and 6 neighbours
  Vector6d gradient = Vector6d::Zero();  // of the score
  Matrix6d hessian = Matrix6d::Zero();   // of the score; negative definite at a good match
  double nearest_sum = 0.0;              // sum over points of the largest single term
  std::uint32_t scored_points = 0;       // points that have any ND near
};

// Exact, in double, without allocating. `points_m` in the frame of the pose.
MatchScore match_score(const MatchGrid& grid, std::span<const Eigen::Vector3d> points_m,
                       const Pose& T_map_sensor);

// The pose after that motion.
Pose moved(const Pose& T_map_sensor, const Vector6d& motion);

// How sharply the score is peaked in the plane, all other motions free to follow: the Schur
// complement of a MatchResult's Hessian, 1/m^2. Allocates nothing.
struct HorizontalCurvature {
  double weak = 0.0, strong = 0.0;
  Eigen::Vector2d weak_direction = Eigen::Vector2d::UnitX();  // of length 1
};
HorizontalCurvature horizontal_curvature(const Matrix6d& hessian);

}  // namespace sightline
