#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/match_score.h"

// Small planes that several scans measured, as equations of the scans' poses; part of
// estimate-trajectory.

namespace sightline {

// A scan of the adjustment: thinned points in the sensor's frame, in float to save memory.
struct PlaneScan {
  std::uint32_t key = 0;  // which of the poses sought
  Pose T_map_lidar = Pose::Identity();
  const std::vector<Eigen::Vector3f>* points_m = nullptr;
  // Its pose is fixed: it contributes to planes, and has no rows and columns of its own.
  bool is_held = false;
};

// Normal equations of a few poses: row and column block i belong to scan i of the call, and are
// zero where it is held.
struct PlaneEquations {
  Eigen::MatrixXd hessian;   // 6 m x 6 m; lower triangle of blocks
  Eigen::VectorXd gradient;  // of half the squared residuals
};

// The planes in cells of 1 m within [low, high) that at least two scans, not all of them held,
// measured. Residuals are the points' distances from the plane; its own three unknowns are
// eliminated (Schur), so that terms between scans remain: Gauss-Newton for plane adjustment (Zhou,
// Koppel, Kaess, "LiDAR SLAM with Plane Adjustment", 2021, in cells). Motions of a pose as in
// match_score.h.
PlaneEquations plane_equations(std::span<const PlaneScan> scans, const Eigen::Vector2d& low_m,
                               const Eigen::Vector2d& high_m);

}  // namespace sightline
