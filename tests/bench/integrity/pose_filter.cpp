#include "tests/bench/integrity/pose_filter.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace sightline {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double square(double x) { return x * x; }

enum Place { kX, kY, kYaw, kBias, kSpeed, kScale };

// Standard deviations of what the filter assumes; those of the simulated sensors are a little less.
constexpr double kStart_m = 0.05;
constexpr double kStart_rad = 0.005;
constexpr double kStartBias_rad_per_s = 0.03 * kRadPerDeg;
constexpr double kStartSpeed_m_per_s = 20.0;  // unknown
constexpr double kStartScale = 0.02;
constexpr double kSpeedNoise_m_per_s = 0.1;
constexpr double kAcceleration_m_per_s2 = 2.0;
constexpr double kTurnNoise_rad = 0.04 * kRadPerDeg;  // in a step
constexpr double kSlip_m = 0.01;                      // in a step, across
constexpr double kAlong_m = 0.005;                    // in a step
constexpr double kScaleDrift = 1e-5;                  // in a step
constexpr double kBiasDrift_rad_per_s = 1e-6;

}  // namespace

double wrapped_rad(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

PlanarPose difference(const PlanarPose& a, const PlanarPose& b) {
  return {a.x() - b.x(), a.y() - b.y(), wrapped_rad(a.z() - b.z())};
}

PoseFilter::PoseFilter(const PlanarPose& start) {
  state_.head<3>() = start;
  covariance_.diagonal() << square(kStart_m), square(kStart_m), square(kStart_rad),
      square(kStartBias_rad_per_s), square(kStartSpeed_m_per_s), square(kStartScale);
}

void PoseFilter::predict(const WheelsAndGyro& measured) {
  measure_speed(measured);
  move(measured);
}

void PoseFilter::measure_speed(const WheelsAndGyro& measured) {
  covariance_(kSpeed, kSpeed) += square(kAcceleration_m_per_s2 * measured.seconds);
  Eigen::Matrix<double, 1, 6> by_state = Eigen::Matrix<double, 1, 6>::Zero();
  by_state[kSpeed] = 1.0 + state_[kScale];
  by_state[kScale] = state_[kSpeed];
  const double variance =
      (by_state * covariance_ * by_state.transpose())(0, 0) + square(kSpeedNoise_m_per_s);
  const State gain = covariance_ * by_state.transpose() / variance;
  state_ += gain * (measured.speed_m_per_s - state_[kSpeed] * (1.0 + state_[kScale]));
  covariance_ = ((Covariance::Identity() - gain * by_state) * covariance_).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void PoseFilter::move(const WheelsAndGyro& measured) {
  const double turn_rad = (measured.turn_rad_per_s - state_[kBias]) * measured.seconds;
  const double way_m = state_[kSpeed] * measured.seconds;
  const double heading_rad = state_[kYaw] + 0.5 * turn_rad;
  const double c = std::cos(heading_rad);
  const double s = std::sin(heading_rad);
  Covariance by_state = Covariance::Identity();
  by_state(kX, kYaw) = -s * way_m;
  by_state(kY, kYaw) = c * way_m;
  by_state(kX, kBias) = 0.5 * s * way_m * measured.seconds;
  by_state(kY, kBias) = -0.5 * c * way_m * measured.seconds;
  by_state(kX, kSpeed) = c * measured.seconds;
  by_state(kY, kSpeed) = s * measured.seconds;
  by_state(kYaw, kBias) = -measured.seconds;
  state_[kX] += c * way_m;
  state_[kY] += s * way_m;
  state_[kYaw] = wrapped_rad(state_[kYaw] + turn_rad);
  covariance_ = (by_state * covariance_ * by_state.transpose()).eval();
  covariance_(kX, kX) += square(c * kAlong_m) + square(s * kSlip_m);
  covariance_(kY, kY) += square(s * kAlong_m) + square(c * kSlip_m);
  covariance_(kX, kY) += c * s * (square(kAlong_m) - square(kSlip_m));
  covariance_(kY, kX) = covariance_(kX, kY);
  covariance_(kYaw, kYaw) += square(kTurnNoise_rad);
  covariance_(kBias, kBias) += square(kBiasDrift_rad_per_s);
  covariance_(kScale, kScale) += square(kScaleDrift);
}

void PoseFilter::update(const PlanarPose& pose, const Eigen::Matrix3d& information) {
  const Eigen::Vector3d off = difference(pose, this->pose());
  update_from_here(information * off, information);
}

void PoseFilter::update_from_here(const Eigen::Vector3d& pull, const Eigen::Matrix3d& information) {
  // (P^-1 + H^T I H)^-1 = (1 + P H^T I H)^-1 P, which needs no inverse of I.
  Covariance sum = Covariance::Identity();
  sum.leftCols<3>() += covariance_.leftCols<3>() * information;
  covariance_ = Eigen::PartialPivLU<Covariance>(sum).solve(covariance_).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  state_ += covariance_.leftCols<3>() * pull;
  state_[kYaw] = wrapped_rad(state_[kYaw]);
}

}  // namespace sightline
