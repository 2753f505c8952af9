#pragma once

#include <Eigen/Core>

namespace sightline {

// x, y, yaw; a motion of the vehicle in the plane.
using PlanarPose = Eigen::Vector3d;

// Between two scans.
struct WheelsAndGyro {
  double seconds = 0.1;
  double speed_m_per_s = 0.0;   // of the wheels, off by a scale
  double turn_rad_per_s = 0.0;  // of the gyro, off by a bias
};

// An extended Kalman filter of a vehicle in the plane: x, y, yaw, bias of the gyro, speed, scale of
// the wheels.
class PoseFilter {
 public:
  explicit PoseFilter(const PlanarPose& start);

  void predict(const WheelsAndGyro& measured);
  // A pose with that information, which may be singular. Each is used, however far it is.
  void update(const PlanarPose& pose, const Eigen::Matrix3d& information);
  // Of a measured step from the filter's pose: information times that step.
  void update_from_here(const Eigen::Vector3d& pull, const Eigen::Matrix3d& information);

  [[nodiscard]] PlanarPose pose() const { return state_.head<3>(); }
  [[nodiscard]] Eigen::Matrix3d covariance() const { return covariance_.topLeftCorner<3, 3>(); }

 private:
  using State = Eigen::Matrix<double, 6, 1>;
  using Covariance = Eigen::Matrix<double, 6, 6>;
  void measure_speed(const WheelsAndGyro& measured);
  void move(const WheelsAndGyro& measured);

  State state_ = State::Zero();
  Covariance covariance_ = Covariance::Zero();
};

// To -pi .. pi.
double wrapped_rad(double angle_rad);
PlanarPose difference(const PlanarPose& a, const PlanarPose& b);

}  // namespace sightline
