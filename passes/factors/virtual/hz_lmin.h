#pragma once

#include <Eigen/Core>

namespace sightline {

// Smallest eigenvalue of the summed horizontal part of n n^T: near 0 where some horizontal
// direction is constrained by nothing (schemas/definitions.md, `hz_lmin`). Never below 0.
double hz_lmin(const Eigen::Matrix2d& planar_normals);

}  // namespace sightline
