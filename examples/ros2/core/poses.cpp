#include "poses.h"

#include <algorithm>

namespace sightline_ros2 {
namespace {

std::array<double, 4> normalized(std::array<double, 4> q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& number : q) number /= length;
  return q;
}

double dot(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

}  // namespace

// By the largest of the four, so that none is divided by a small number.
Pose pose_of(const PoseRows& r) {
  const double trace = r[0] + r[5] + r[10];
  const std::array<double, 4> squares = {r[0], r[5], r[10], trace};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  std::array<double, 4> q{};
  if (largest == 3) {
    q = {r[9] - r[6], r[2] - r[8], r[4] - r[1], 1.0 + trace};
  } else if (largest == 0) {
    q = {1.0 + 2.0 * r[0] - trace, r[1] + r[4], r[2] + r[8], r[9] - r[6]};
  } else if (largest == 1) {
    q = {r[1] + r[4], 1.0 + 2.0 * r[5] - trace, r[6] + r[9], r[2] - r[8]};
  } else {
    q = {r[2] + r[8], r[6] + r[9], 1.0 + 2.0 * r[10] - trace, r[4] - r[1]};
  }
  return {{r[3], r[7], r[11]}, normalized(q)};
}

PoseRows product(const PoseRows& a, const PoseRows& b) {
  PoseRows c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      c[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j];
    }
    c[4 * i + 3] += a[4 * i + 3];
  }
  return c;
}

PoseRows inverse(const PoseRows& a) {
  PoseRows b{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) b[4 * i + j] = a[4 * j + i];
    b[4 * i + 3] = -(a[i] * a[3] + a[4 + i] * a[7] + a[8 + i] * a[11]);
  }
  return b;
}

std::array<double, 3> transformed(const PoseRows& a, const std::array<double, 3>& p_m) {
  std::array<double, 3> q_m{};
  for (std::size_t i = 0; i < 3; ++i) {
    q_m[i] = a[4 * i] * p_m[0] + a[4 * i + 1] * p_m[1] + a[4 * i + 2] * p_m[2] + a[4 * i + 3];
  }
  return q_m;
}

double distance_m(const std::array<double, 3>& a_m, const std::array<double, 3>& b_m) {
  return std::hypot(a_m[0] - b_m[0], a_m[1] - b_m[1], a_m[2] - b_m[2]);
}

double turn_rad(const Pose& a, const Pose& b) {
  const double cosine = std::abs(dot(a.quaternion_xyzw, b.quaternion_xyzw));
  return 2.0 * std::acos(std::min(1.0, cosine));
}

Pose interpolated(const Pose& from, const Pose& to, double share) {
  Pose pose;
  for (std::size_t i = 0; i < 3; ++i) {
    pose.position_m[i] = from.position_m[i] + share * (to.position_m[i] - from.position_m[i]);
  }
  const std::array<double, 4>& p = from.quaternion_xyzw;
  std::array<double, 4> q = to.quaternion_xyzw;
  if (dot(p, q) < 0.0) {
    for (double& number : q) number = -number;
  }
  const double angle = std::acos(std::min(1.0, dot(p, q)));
  // Below that the weights of a great circle are those of the line to all bits.
  const bool is_small = angle < 1e-6;
  const double a = is_small ? 1.0 - share : std::sin((1.0 - share) * angle) / std::sin(angle);
  const double b = is_small ? share : std::sin(share * angle) / std::sin(angle);
  for (std::size_t i = 0; i < 4; ++i) pose.quaternion_xyzw[i] = a * p[i] + b * q[i];
  pose.quaternion_xyzw = normalized(pose.quaternion_xyzw);
  return pose;
}

std::array<double, 4> quaternion_of_yaw(double yaw_rad) {
  return {0.0, 0.0, std::sin(0.5 * yaw_rad), std::cos(0.5 * yaw_rad)};
}

std::array<double, 4> product(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

}  // namespace sightline_ros2
