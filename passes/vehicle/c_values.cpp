#include "passes/vehicle/c_values.h"

#include <cmath>
#include <cstddef>
#include <cstring>

namespace sightline {
namespace {

using PoseRows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

template <class Number>
void take_numbers(const PointsInMemory& from, std::vector<Eigen::Vector3d>& points_m) {
  const char* place = static_cast<const char*>(from.first);
  for (std::size_t i = 0; i < from.count; ++i, place += from.stride_bytes) {
    Number xyz[3];
    std::memcpy(xyz, place, sizeof xyz);
    const Eigen::Vector3d point_m(xyz[0], xyz[1], xyz[2]);
    if (point_m.allFinite() && !point_m.isZero(0.0)) points_m.push_back(point_m);
  }
}

}  // namespace

void put_matrix(const Matrix6d& symmetric, double numbers[36]) {
  Eigen::Map<Matrix6d>(numbers, 6, 6) = symmetric;
}

Pose pose_of(const double rows[12]) {
  Pose pose = Pose::Identity();
  pose.affine() = Eigen::Map<const PoseRows>(rows);
  return pose;
}

void put_pose(const Pose& pose, double rows[12]) {
  Eigen::Map<PoseRows>(rows, 3, 4) = pose.affine();
}

void take_returns(const PointsInMemory& from, std::vector<Eigen::Vector3d>& points_m) {
  points_m.clear();
  points_m.reserve(from.count);
  if (from.is_double) {
    take_numbers<double>(from, points_m);
  } else {
    take_numbers<float>(from, points_m);
  }
}

std::optional<MatchKnowledge> knowledge_of(const double* start_covariance, double variance_factor,
                                           double map_m, double map_rad) {
  MatchKnowledge knowledge;
  if (start_covariance != nullptr) {
    const Eigen::Map<const Matrix6d> given(start_covariance);
    if (!is_covariance(given)) return std::nullopt;
    knowledge.start_covariance = 0.5 * (given + given.transpose());
  }
  for (const double number : {variance_factor, map_m, map_rad}) {
    if (!(number >= 0.0 && std::isfinite(number))) return std::nullopt;
  }
  if (variance_factor > 0.0) knowledge.scale.variance_factor = variance_factor;
  if (map_m > 0.0 || map_rad > 0.0) {
    knowledge.scale.map_m = map_m;
    knowledge.scale.map_rad = map_rad;
  }
  return knowledge;
}

}  // namespace sightline
