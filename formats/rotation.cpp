#include "formats/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "formats/base/portable_math.h"

namespace sightline {

AxisAngle axis_angle(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  const double length = q.vec().norm();
  if (length == 0.0) return {};
  // q and -q are one rotation.
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return {sign / length * q.vec(), 2.0 * portable_atan2(length, std::abs(q.w()))};
}

Eigen::Matrix3d rotation_matrix(const AxisAngle& turn) {
  const SinCos half = portable_sin_cos(0.5 * turn.angle_rad);
  const Eigen::Vector3d vector = half.sin * turn.axis;
  return Eigen::Quaterniond(half.cos, vector.x(), vector.y(), vector.z()).toRotationMatrix();
}

double rotation_angle_rad(const Eigen::Matrix3d& rotation) {
  return axis_angle(rotation).angle_rad;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const AxisAngle turn = axis_angle(rotation);
  return turn.angle_rad * turn.axis;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad) {
  const SinCos azimuth = portable_sin_cos(azimuth_rad);
  const SinCos elevation = portable_sin_cos(elevation_rad);
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}

}  // namespace sightline
