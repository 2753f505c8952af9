#include "formats/geometry.h"

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

}  // namespace sightline
