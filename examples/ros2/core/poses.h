#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "passes/vehicle/vehicle_localizer.h"

// Poses as messages of ROS have them, and as the libraries take them. No ROS here.

namespace sightline_ros2 {

using sightline::PoseRows;
using Covariance = std::array<double, 36>;  // of x y z and turns about the frame's axes, row by row

// Of a child frame in a parent frame.
struct Pose {
  std::array<double, 3> position_m{};
  std::array<double, 4> quaternion_xyzw = {0.0, 0.0, 0.0, 1.0};
};

struct StampedPose {
  std::int64_t stamp_ns = 0;
  Pose pose;
  Covariance covariance{};
};

inline PoseRows rows_of(const Pose& pose) {
  return sightline::pose_rows(pose.position_m, pose.quaternion_xyzw);
}
Pose pose_of(const PoseRows& rows);

// T_a_c = T_a_b * T_b_c
PoseRows product(const PoseRows& a, const PoseRows& b);
PoseRows inverse(const PoseRows& rows);
std::array<double, 3> transformed(const PoseRows& rows, const std::array<double, 3>& p_m);

double distance_m(const std::array<double, 3>& a_m, const std::array<double, 3>& b_m);
// Of the turn from one pose to the other, from 0 to pi.
double turn_rad(const Pose& a, const Pose& b);

// `share` of the way from one pose to the other; below 0 and above 1 outside of them.
Pose interpolated(const Pose& from, const Pose& to, double share);

// A turn about the z axis.
std::array<double, 4> quaternion_of_yaw(double yaw_rad);
std::array<double, 4> product(const std::array<double, 4>& a, const std::array<double, 4>& b);

}  // namespace sightline_ros2
