#include "passes/vehicle/c_values.h"

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

}  // namespace sightline
