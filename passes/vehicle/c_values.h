#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "formats/geometry.h"
#include "passes/matching/covariance/known_start.h"
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

struct MatchKnowledge {
  std::optional<Matrix6d> start_covariance;
  InformationScale scale = default_information_scale();
};
// 36 numbers or null; errors of the map as in sightline_match_options, 0: default. Nothing where a
// number makes no sense.
std::optional<MatchKnowledge> knowledge_of(const double* start_covariance, double variance_factor,
                                           double map_m, double map_rad);

}  // namespace sightline
