#pragma once

#include <Eigen/Core>

#include "passes/matching/match_score.h"

namespace sightline {

// How sharply the score is peaked in the plane, all other motions free to follow: the Schur
// complement of a MatchResult's Hessian, 1/m^2. Allocates nothing.
struct HorizontalCurvature {
  double weak = 0.0, strong = 0.0;
  Eigen::Vector2d weak_direction = Eigen::Vector2d::UnitX();  // of length 1
};
HorizontalCurvature horizontal_curvature(const Matrix6d& hessian);

}  // namespace sightline
