#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/following/sample_integral.h"

// How far the vehicle moved between two scans by its wheels or its accelerometer, for steps whose
// way the scans do not constrain ("Forecasts of the way" in schemas/definitions.md, v1); part of
// estimate-trajectory.

namespace sightline {

// A step between two scans, poses of the sensor.
struct ScanStep {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
  Pose T_map_from = Pose::Identity();
  Pose T_map_to = Pose::Identity();
};

// What the sensors of a drive measured of its motion, for steps between stamps.
class MotionSensors {
 public:
  explicit MotionSensors(const Drive& drive);

  // By the wheels; none where they did not measure all the time.
  [[nodiscard]] std::optional<double> wheel_way_m(std::int64_t from_ns, std::int64_t to_ns) const;

  // What acceleration along an axis of the sensor adds to the speed, and to the way beside that at
  // constant speed; gravity is removed by the tilt of both poses. None as before.
  struct Gain {
    double speed_m_s = 0.0;
    double way_m = 0.0;
    double time_s = 0.0;
  };
  [[nodiscard]] std::optional<Gain> gain(const ScanStep& step, const Eigen::Vector3d& ahead) const;

  // The x axis of the vehicle in the sensor's axes.
  [[nodiscard]] const Eigen::Vector3d& x_axis() const { return x_axis_; }

 private:
  SampleIntegral speeds_;
  SampleIntegral forces_;  // about the sensor's axes
  Eigen::Vector3d x_axis_;
};

// The way of a step, but for gain.way_m, by the speed and the bias before it: their factors.
Eigen::Vector2d way_by_state(const MotionSensors::Gain& gain);

// The direction in which the vehicle moves forward, in the sensor's axes: by its steps, since the
// mounting of a sensor may not be known.
class DirectionAhead {
 public:
  DirectionAhead() = default;
  explicit DirectionAhead(const Eigen::Vector3d& x_axis) : x_axis_(x_axis), ahead_(x_axis) {}
  // A step that scans constrain. The sign is that of the wheels, else nearer to the x axis.
  void take(const Eigen::Vector3d& moved_m, const std::optional<double>& wheel_way_m);
  [[nodiscard]] const Eigen::Vector3d& ahead() const { return ahead_; }

 private:
  Eigen::Vector3d x_axis_ = Eigen::Vector3d::UnitX();
  Eigen::Vector3d ahead_ = Eigen::Vector3d::UnitX();
  bool is_known_ = false;
};

// Ways by scans where these constrain it, and by wheels: the ratio of both.
class WheelScale {
 public:
  void add(double way_m, double wheel_way_m);
  // Way for each metre of the wheels, with a prior of 1 +/- 0.02.
  [[nodiscard]] double way_per_wheel() const;
  [[nodiscard]] double sigma() const;
  // Whether most steps by the wheels are not those of the scans.
  [[nodiscard]] bool is_contradicted() const;

 private:
  double way_m_ = 0.0;  // of steps that agree
  double wheel_way_m_ = 0.0;
  std::size_t agreeing_ = 0;
  std::size_t others_ = 0;
};

// Errors of accelerations along the way: white noise with that of the road and of the tilt, and a
// bias that wanders with it. `way_m`: of one step by scans.
struct InertialNoise {
  double way_m = 0.01;
  double speed_m_s_per_sqrt_s = 0.05;
  double bias_m_s2_per_sqrt_s = 0.005;
  double first_speed_m_s = 30.0;
  double first_bias_m_s2 = 0.3;
};

// Speed and the accelerometer's bias along the direction of motion, by a Kalman filter.
class InertialSpeed {
 public:
  [[nodiscard]] bool is_known() const;
  [[nodiscard]] double way_m(const MotionSensors::Gain& gain) const;
  [[nodiscard]] double way_sigma_m(const MotionSensors::Gain& gain) const;
  // A step of a way that scans measured, or did not.
  void take(const MotionSensors::Gain& gain, std::optional<double> way_m);

 private:
  Eigen::Vector2d state_ = Eigen::Vector2d::Zero();  // m/s and m/s2
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();
  std::size_t measured_ = 0;  // steps
};

// Compares ways by scans that hold little with those that the vehicle's sensors measured.
class WayCheck {
 public:
  // A way by scans that is `off_m` longer than the measured one, whose standard deviation is given:
  // not where it is 3 cm and three of these off, or the latest ways on average 1 cm, since steps
  // that are each a little short are metres along a tunnel.
  [[nodiscard]] bool refutes(double off_m, double sigma_m) const;
  void take(double off_m) { mean_off_m_ = mean_with(off_m); }

 private:
  [[nodiscard]] double mean_with(double off_m) const;
  double mean_off_m_ = 0.0;
};

// Follows a drive step by step.
class SpeedForecast {
 public:
  SpeedForecast() = default;  // of a drive without such sensors
  explicit SpeedForecast(const Drive& drive);

  struct Way {
    Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();  // in the sensor's axes before the step
    Forecast source = Forecast::kNone;
    double share = 0.0;    // standard deviation along a stretch, as a share of the way
    double sigma_m = 0.0;  // of this step
  };
  // The way of the next step, whose second pose is not used; by wheels rather than by
  // accelerations. None where neither is known.
  [[nodiscard]] std::optional<Way> way(const ScanStep& step) const;

  // A step of the drive; `is_constrained`: its way is that of the scans.
  void take(const ScanStep& step, bool is_constrained);
  // A piece begins: its speed is not known.
  void begin_piece() { inertial_ = {}; }

  [[nodiscard]] const MotionSensors* sensors() const { return sensors_.get(); }
  [[nodiscard]] const Eigen::Vector3d& ahead() const { return direction_.ahead(); }
  [[nodiscard]] const WheelScale& wheels() const { return wheels_; }

 private:
  std::shared_ptr<const MotionSensors> sensors_;
  DirectionAhead direction_;
  WheelScale wheels_;
  InertialSpeed inertial_;
};

}  // namespace sightline
