#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/match_score.h"

// Numbers of the C interface as values of this program, and back.

namespace sightline {

Pose pose_of(const double rows[12]);
void put_pose(const Pose& pose, double rows[12]);
void put_matrix(const Matrix6d& symmetric, double numbers[36]);

// x, y and z of each point, as they are in memory.
struct PointsInMemory {
  const void* first = nullptr;
  std::size_t count = 0;
  std::size_t stride_bytes = 0;
  bool is_double = false;
};
// Without what is no return.
void take_returns(const PointsInMemory& from, std::vector<Eigen::Vector3d>& points_m);

}  // namespace sightline
