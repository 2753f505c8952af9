#include "formats/geometry.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Shoemake's spherical interpolation (1985), along the shorter way; both of unit length.
Eigen::Quaterniond slerp(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                         double fraction) {
  constexpr double kNearlySame = 1.0 - 1e-15;
  const double cosine = from.dot(to);
  double of_from = 1.0 - fraction;
  double of_to = fraction;
  if (std::abs(cosine) < kNearlySame) {
    const double angle_rad = portable_acos(std::abs(cosine));
    const double whole = portable_sin_cos(angle_rad).sin;
    of_from = portable_sin_cos(of_from * angle_rad).sin / whole;
    of_to = portable_sin_cos(of_to * angle_rad).sin / whole;
  }
  if (cosine < 0.0) of_to = -of_to;
  return Eigen::Quaterniond(of_from * from.coeffs() + of_to * to.coeffs());
}

}  // namespace

MapFrame frame_near(const Eigen::Vector3d& near_world_m, double tile_m) {
  MapFrame frame;
  for (int axis = 0; axis < 3; ++axis) {
    // Adding zero makes -0.0 plain, which is another byte in the map.
    frame.origin_world_m[axis] = std::floor(near_world_m[axis] / tile_m) * tile_m + 0.0;
  }
  return frame;
}

Pose rebase(const Pose& T_from_x, const MapFrame& from, const MapFrame& to) {
  Pose T_to_x = T_from_x;
  T_to_x.translation() += from.origin_world_m - to.origin_world_m;
  return T_to_x;
}

bool is_rigid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d rotation = pose.linear();
  const Eigen::Matrix3d excess = rotation * rotation.transpose() - Eigen::Matrix3d::Identity();
  return excess.cwiseAbs().maxCoeff() < 1e-6 && rotation.determinant() > 0.0;
}

Pose interpolate(const Pose& a, const Pose& b, double fraction) {
  const Eigen::Quaterniond from(a.linear());
  const Eigen::Quaterniond to(b.linear());
  Pose pose = Pose::Identity();
  pose.linear() = slerp(from, to, fraction).normalized().toRotationMatrix();
  pose.translation() = a.translation() + fraction * (b.translation() - a.translation());
  return pose;
}

void append_facts(const MapFrame& frame, Table& table) {
  table.facts.emplace_back("origin_world_x_m", frame.origin_world_m.x());
  table.facts.emplace_back("origin_world_y_m", frame.origin_world_m.y());
  table.facts.emplace_back("origin_world_z_m", frame.origin_world_m.z());
}

void append_pose_columns(std::vector<std::string>& columns) {
  for (const char* name : {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"}) columns.emplace_back(name);
}

void append_cells(const Pose& pose, std::vector<Cell>& row) {
  Eigen::Quaterniond rotation(pose.linear());
  // q and -q are one rotation: print one of them.
  if (rotation.w() < 0.0) rotation.coeffs() = -rotation.coeffs();
  for (int axis = 0; axis < 3; ++axis) row.emplace_back(pose.translation()[axis]);
  for (int i = 0; i < 4; ++i) row.emplace_back(rotation.coeffs()[i]);
}

void encode(const Pose& pose, ByteWriter& writer) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) writer.put(pose(row, column));
  }
}

void decode(ByteReader& reader, Pose& pose) {
  pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) reader.get(pose(row, column));
  }
}

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
