#pragma once

#include <Eigen/Core>

// What Eigen's AngleAxis does, with the same bits on every machine: its sines and arc tangents are
// the C library's (formats/base/portable_math.h).

namespace sightline {

struct AxisAngle {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit length
  double angle_rad = 0.0;
};
AxisAngle axis_angle(const Eigen::Matrix3d& rotation);  // angle in [0, pi]
Eigen::Matrix3d rotation_matrix(const AxisAngle& turn);
double rotation_angle_rad(const Eigen::Matrix3d& rotation);        // in [0, pi]
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);  // axis times angle, rad

// The rotation nearest to a matrix that is one but for rounding: U V^T of its singular value
// decomposition (Kabsch 1976).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

// Of unit length: azimuth from +x to +y, elevation from the plane to +z.
Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad);

}  // namespace sightline
