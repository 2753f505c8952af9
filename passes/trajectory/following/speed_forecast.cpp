#include "passes/trajectory/following/speed_forecast.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "formats/base/units.h"

// Wheels: a scale that is off by percents for a whole drive (pressure and wear of tires), so its
// error grows linearly with the way. Accelerations: twice integrated, an error of 0.01 m/s2 is 4.5
// m after 30 s; the bias along the way, with what a wrong tilt leaves of gravity, is estimated with
// the speed wherever scans measure the way.

namespace sightline {
namespace {

double square(double value) { return value * value; }

// Samples farther apart leave the speed between them unknown.
constexpr std::int64_t kLongestWheelStep_ns = kSecond_ns / 2;
constexpr std::int64_t kLongestForceStep_ns = kSecond_ns / 20;
constexpr double kGravity_m_s2 = 9.80665;
// Of wheels before any step is compared, and of the way by scans over hundreds of metres.
constexpr double kScalePrior = 0.02;
constexpr double kScanScale = 0.003;
// Of a way by scans of any length.
constexpr double kWaySigma_m = 0.03;
// Steps that differ by more have another cause than scale: slip, another clock, a wrong match.
constexpr double kAgreeing = 0.1;
constexpr double kAgreeing_m = 0.05;
constexpr std::size_t kLeastJudged = 20;
constexpr double kMostOff_m = 0.03;
constexpr double kMostMeanOff_m = 0.01;
constexpr double kNewOff = 0.2;
// A vehicle that stands has no direction of motion.
constexpr double kLeastStep_m = 0.1;
constexpr double kNewDirection = 0.1;
constexpr std::size_t kLeastMeasured = 10;
// Of a way by accelerations before the scans behind it are known.
constexpr double kInertialShare = 0.03;

}  // namespace

void DirectionAhead::take(const Eigen::Vector3d& moved_m,
                          const std::optional<double>& wheel_way_m) {
  const double length_m = moved_m.norm();
  if (length_m < kLeastStep_m) return;
  const bool is_back =
      wheel_way_m ? *wheel_way_m < 0.0 : moved_m.dot(is_known_ ? ahead_ : x_axis_) < 0.0;
  const Eigen::Vector3d ahead = (is_back ? -1.0 : 1.0) / length_m * moved_m;
  const double share = is_known_ ? kNewDirection : 1.0;
  ahead_ = (ahead_ + share * (ahead - ahead_)).normalized();
  is_known_ = true;
}

Eigen::Vector2d way_by_state(const MotionSensors::Gain& gain) {
  return {gain.time_s, -0.5 * gain.time_s * gain.time_s};
}

MotionSensors::MotionSensors(const Drive& drive)
    : speeds_(kLongestWheelStep_ns),
      forces_(kLongestForceStep_ns),
      x_axis_(drive.sensor.T_vehicle_lidar.linear().transpose() * Eigen::Vector3d::UnitX()) {
  for (const WheelSpeed& speed : drive.wheel_speeds) {
    speeds_.add(speed.stamp_ns, speed.speed_m_s * Eigen::Vector3d::UnitX());
  }
  const Eigen::Matrix3d R_lidar_vehicle = drive.sensor.T_vehicle_lidar.linear().transpose();
  for (const SpecificForce& force : drive.specific_forces) {
    forces_.add(force.stamp_ns, R_lidar_vehicle * force.force_m_s2);
  }
}

std::optional<double> MotionSensors::wheel_way_m(std::int64_t from_ns, std::int64_t to_ns) const {
  const std::optional<SampleIntegral::Between> way = speeds_.between(from_ns, to_ns);
  return way ? std::optional(way->once.x()) : std::nullopt;
}

std::optional<MotionSensors::Gain> MotionSensors::gain(const ScanStep& step,
                                                       const Eigen::Vector3d& ahead) const {
  const std::optional<SampleIntegral::Between> force = forces_.between(step.from_ns, step.to_ns);
  if (!force) return std::nullopt;
  const double time_s =
      static_cast<double>(step.to_ns - step.from_ns) / static_cast<double>(kSecond_ns);
  const double climb = 0.5 * ((step.T_map_from.linear() + step.T_map_to.linear()) * ahead).z();
  const double gravity_m_s2 = kGravity_m_s2 * climb;
  return Gain{ahead.dot(force->once) - gravity_m_s2 * time_s,
              ahead.dot(force->twice) - 0.5 * gravity_m_s2 * time_s * time_s, time_s};
}

void WheelScale::add(double way_m, double wheel_way_m) {
  const bool agrees =
      std::abs(way_m - wheel_way_m) <= kAgreeing * std::abs(wheel_way_m) + kAgreeing_m;
  (agrees ? agreeing_ : others_) += 1;
  if (!agrees) return;
  way_m_ += std::abs(way_m);
  wheel_way_m_ += std::abs(wheel_way_m);
}

double WheelScale::sigma() const {
  if (way_m_ == 0.0) return kScalePrior;
  const double measured = kScanScale + kWaySigma_m / way_m_;
  return 1.0 / std::sqrt(1.0 / (kScalePrior * kScalePrior) + 1.0 / (measured * measured));
}

double WheelScale::way_per_wheel() const {
  if (wheel_way_m_ == 0.0) return 1.0;
  const double share = 1.0 - square(sigma() / kScalePrior);  // of what was measured
  return 1.0 + share * (way_m_ / wheel_way_m_ - 1.0);
}

bool WheelScale::is_contradicted() const {
  return agreeing_ + others_ >= kLeastJudged && others_ > agreeing_;
}

bool InertialSpeed::is_known() const { return measured_ >= kLeastMeasured; }

double InertialSpeed::way_m(const MotionSensors::Gain& gain) const {
  return gain.way_m + way_by_state(gain).dot(state_);
}

double InertialSpeed::way_sigma_m(const MotionSensors::Gain& gain) const {
  const Eigen::Vector2d by_state = way_by_state(gain);
  return std::sqrt(by_state.dot(covariance_ * by_state));
}

void InertialSpeed::take(const MotionSensors::Gain& gain, std::optional<double> way_m) {
  const InertialNoise noise;
  if (measured_ == 0) {
    covariance_.diagonal() << square(noise.first_speed_m_s), square(noise.first_bias_m_s2);
  }
  if (way_m) {
    const Eigen::Vector2d by_state = way_by_state(gain);
    const Eigen::Vector2d with_state = covariance_ * by_state;
    const double variance_m2 = by_state.dot(with_state) + noise.way_m * noise.way_m;
    const double off_m = *way_m - this->way_m(gain);
    state_ += with_state / variance_m2 * off_m;
    covariance_ -= with_state * with_state.transpose() / variance_m2;
    ++measured_;
  }
  Eigen::Matrix2d change;
  change << 1.0, -gain.time_s, 0.0, 1.0;
  state_ = change * state_ + Eigen::Vector2d(gain.speed_m_s, 0.0);
  covariance_ = change * covariance_ * change.transpose();
  covariance_.diagonal() += gain.time_s * Eigen::Vector2d(square(noise.speed_m_s_per_sqrt_s),
                                                          square(noise.bias_m_s2_per_sqrt_s));
}

double WayCheck::mean_with(double off_m) const {
  return mean_off_m_ + kNewOff * (off_m - mean_off_m_);
}

bool WayCheck::refutes(double off_m, double sigma_m) const {
  const double most_m = 3.0 * sigma_m;
  return std::abs(off_m) > kMostOff_m + most_m ||
         std::abs(mean_with(off_m)) > kMostMeanOff_m + most_m;
}

SpeedForecast::SpeedForecast(const Drive& drive) {
  if (drive.wheel_speeds.empty() && drive.specific_forces.empty()) return;
  sensors_ = std::make_shared<const MotionSensors>(drive);
  direction_ = DirectionAhead(sensors_->x_axis());
}

std::optional<SpeedForecast::Way> SpeedForecast::way(const ScanStep& step) const {
  if (!sensors_) return std::nullopt;
  const std::optional<double> wheel_m = sensors_->wheel_way_m(step.from_ns, step.to_ns);
  if (wheel_m && !wheels_.is_contradicted()) {
    return Way{wheels_.way_per_wheel() * *wheel_m * ahead(), Forecast::kWheels, wheels_.sigma(),
               wheels_.sigma() * std::abs(*wheel_m)};
  }
  if (!inertial_.is_known()) return std::nullopt;
  ScanStep level = step;
  level.T_map_to = step.T_map_from;
  const std::optional<MotionSensors::Gain> gain = sensors_->gain(level, ahead());
  if (!gain) return std::nullopt;
  return Way{inertial_.way_m(*gain) * ahead(), Forecast::kInertial, kInertialShare,
             inertial_.way_sigma_m(*gain)};
}

void SpeedForecast::take(const ScanStep& step, bool is_constrained) {
  if (!sensors_) return;
  const Eigen::Vector3d moved_m = (step.T_map_from.inverse() * step.T_map_to).translation();
  const std::optional<double> wheel_m = sensors_->wheel_way_m(step.from_ns, step.to_ns);
  if (is_constrained) direction_.take(moved_m, wheel_m);
  const double way_m = ahead().dot(moved_m);
  if (is_constrained && wheel_m) wheels_.add(way_m, *wheel_m);
  const std::optional<MotionSensors::Gain> gain = sensors_->gain(step, ahead());
  if (!gain) {
    inertial_ = {};
  } else {
    inertial_.take(*gain, is_constrained ? std::optional(way_m) : std::nullopt);
  }
}

}  // namespace sightline
