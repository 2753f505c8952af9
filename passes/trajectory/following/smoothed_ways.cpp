#include "passes/trajectory/following/smoothed_ways.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/units.h"
#include "passes/trajectory/following/speed_forecast.h"
#include "passes/trajectory/local/local_match.h"

// Speeds v and biases b at all scans of a piece by least squares (Rauch, Tung, Striebel, "Maximum
// likelihood estimates of linear dynamic systems", 1965, in the form of normal equations):
//   v' = v + gain - b t,   b' = b,   way of a step = v t + gain - b t^2 / 2 where scans measure it.
// Two unknowns a scan, and each is connected with the next: a band that is solved in one sweep. The
// variance of a way, w^T x, is w^T y with the solution y of the same equations for w.

namespace sightline {
namespace {

// A step of the odometry and what the vehicle's sensors measured of it.
struct SensedStep {
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitX();  // in the axes of the sensor before the step
  double way_m = 0.0;                                // along it, by the odometry
  std::optional<double> wheel_way_m;
  std::optional<MotionSensors::Gain> gain;
};

// A way that replaces that of a step, and its standard deviation as a share of it.
struct SmoothedWay {
  double way_m = 0.0;
  double share = 0.0;
};

ScanStep scan_step(const Drive& drive, const Odometry& odometry, std::size_t k) {
  return {drive.scans[k - 1].stamp_ns, drive.scans[k].stamp_ns, odometry.T_map_lidar[k - 1],
          odometry.T_map_lidar[k]};
}

bool is_forecast_by(const StepConstraint& step, Forecast source) {
  return step.forecast == source && step.weak[0] > 0.0;
}

class BandEquations {
 public:
  explicit BandEquations(std::size_t count)
      : own_(count, Eigen::Matrix2d::Zero()),
        next_(count, Eigen::Matrix2d::Zero()),
        right_(count, Eigen::Vector2d::Zero()) {}

  // by_first * x[i] + by_second * x[i + 1] = value, with a weight.
  void add(std::size_t i, const Eigen::Vector2d& by_first, const Eigen::Vector2d& by_second,
           double value, double weight) {
    own_[i] += weight * by_first * by_first.transpose();
    right_[i] += weight * value * by_first;
    if (by_second.isZero(0.0)) return;
    next_[i] += weight * by_first * by_second.transpose();
    own_[i + 1] += weight * by_second * by_second.transpose();
    right_[i + 1] += weight * value * by_second;
  }

  [[nodiscard]] std::vector<Eigen::Vector2d> solved() const { return solved(right_); }
  [[nodiscard]] std::vector<Eigen::Vector2d> solved(std::vector<Eigen::Vector2d> right) const {
    std::vector<Eigen::Matrix2d> inverse(own_.size());
    inverse[0] = own_[0].inverse();
    for (std::size_t i = 1; i < own_.size(); ++i) {
      const Eigen::Matrix2d carried = next_[i - 1].transpose() * inverse[i - 1];
      inverse[i] = (own_[i] - carried * next_[i - 1]).inverse();
      right[i] -= carried * right[i - 1];
    }
    for (std::size_t i = own_.size(); i-- > 0;) {
      if (i + 1 < own_.size()) right[i] -= next_[i] * right[i + 1];
      right[i] = (inverse[i] * right[i]).eval();
    }
    return right;
  }

 private:
  std::vector<Eigen::Matrix2d> own_;
  std::vector<Eigen::Matrix2d> next_;  // of an unknown and the one behind it
  std::vector<Eigen::Vector2d> right_;
};

// Steps [begin, end) in a row whose accelerations were measured.
class InertialRun {
 public:
  InertialRun(const std::vector<SensedStep>& steps, const Odometry& odometry, std::size_t begin,
              std::size_t end)
      : steps_(steps), odometry_(odometry), begin_(begin), end_(end), equations_(end - begin + 1) {
    const InertialNoise noise;
    add(0, Eigen::Vector2d::UnitX(), 0.0, noise.first_speed_m_s);
    add(0, Eigen::Vector2d::UnitY(), 0.0, noise.first_bias_m_s2);
    for (std::size_t k = begin; k < end; ++k) add_step(k, noise);
    solution_ = equations_.solved();
  }

  // Replaces the ways of steps by accelerations; neighbours of up to five other steps are one
  // stretch.
  void smooth(std::vector<std::optional<SmoothedWay>>& ways) const {
    constexpr std::size_t kMostBetween = 5;
    std::vector<std::size_t> stretch;
    for (std::size_t k = begin_; k < end_; ++k) {
      if (!is_forecast_by(odometry_.constraint[k], Forecast::kInertial)) continue;
      if (!stretch.empty() && k - stretch.back() > kMostBetween + 1) {
        smooth_stretch(stretch, ways);
        stretch.clear();
      }
      stretch.push_back(k);
    }
    smooth_stretch(stretch, ways);
  }

 private:
  void add(std::size_t i, const Eigen::Vector2d& by_state, double value, double sigma) {
    equations_.add(i, by_state, Eigen::Vector2d::Zero(), value, 1.0 / (sigma * sigma));
  }
  void add_step(std::size_t k, const InertialNoise& noise) {
    const MotionSensors::Gain& gain = *steps_[k].gain;
    const std::size_t i = k - begin_;
    const auto weight = [&](double sigma) -> double { return 1.0 / (sigma * sigma * gain.time_s); };
    equations_.add(i, Eigen::Vector2d(-1.0, gain.time_s), Eigen::Vector2d::UnitX(), gain.speed_m_s,
                   weight(noise.speed_m_s_per_sqrt_s));
    equations_.add(i, -Eigen::Vector2d::UnitY(), Eigen::Vector2d::UnitY(), 0.0,
                   weight(noise.bias_m_s2_per_sqrt_s));
    if (odometry_.constraint[k].weak[0] > 0.0) return;
    add(i, way_by_state(gain), steps_[k].way_m - gain.way_m, noise.way_m);
  }

  void smooth_stretch(const std::vector<std::size_t>& stretch,
                      std::vector<std::optional<SmoothedWay>>& ways) const {
    std::vector<Eigen::Vector2d> weights(solution_.size(), Eigen::Vector2d::Zero());
    double way_m = 0.0;
    for (const std::size_t k : stretch) {
      const MotionSensors::Gain& gain = *steps_[k].gain;
      const Eigen::Vector2d by = way_by_state(gain);
      weights[k - begin_] = by;
      ways[k] = SmoothedWay{by.dot(solution_[k - begin_]) + gain.way_m, 0.0};
      way_m += std::abs(ways[k]->way_m);
    }
    if (way_m == 0.0) return;
    const std::vector<Eigen::Vector2d> changed = equations_.solved(weights);
    double variance_m2 = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) variance_m2 += weights[i].dot(changed[i]);
    for (const std::size_t k : stretch) ways[k]->share = std::sqrt(variance_m2) / way_m;
  }

  const std::vector<SensedStep>& steps_;
  const Odometry& odometry_;
  std::size_t begin_;
  std::size_t end_;
  BandEquations equations_;
  std::vector<Eigen::Vector2d> solution_;
};

// Runs of one piece in which all accelerations were measured.
std::vector<ScanRange> inertial_runs(const std::vector<SensedStep>& steps,
                                     const Odometry& odometry) {
  std::vector<ScanRange> runs;
  for (std::uint32_t k = 1; k < steps.size(); ++k) {
    if (!steps[k].gain || odometry.piece[k] != odometry.piece[k - 1]) continue;
    if (runs.empty() || runs.back().end != k) runs.push_back({k, k});
    runs.back().end = k + 1;
  }
  return runs;
}

// The clock of the wheels relative to that of the scans: compared by the mean speeds of steps that
// scans constrain, for clocks up to 0.5 s apart.
class WheelClock {
 public:
  WheelClock(const Drive& drive, const Odometry& odometry, const std::vector<SensedStep>& steps,
             const MotionSensors& sensors)
      : sensors_(sensors) {
    for (std::size_t k = 1; k < steps.size(); ++k) {
      const ScanStep step = scan_step(drive, odometry, k);
      const bool is_compared =
          steps[k].wheel_way_m && odometry.constraint[k].weak[0] == 0.0 &&
          sensors.wheel_way_m(step.from_ns - kFarthest_ns, step.to_ns + kFarthest_ns);
      if (!is_compared) continue;
      const double time_s = 1e-9 * static_cast<double>(step.to_ns - step.from_ns);
      compared_.push_back({step.from_ns, step.to_ns, time_s, steps[k].way_m / time_s});
    }
  }

  // How far it is ahead; 0 where another one does not explain clearly more.
  [[nodiscard]] std::int64_t ahead_ns() const {
    const double spread = unexplained([](const Compared&) { return 1.0; });
    if (compared_.size() < kLeastCompared || spread < kLeastSpread_m2_s2) return 0;
    const double as_is = unexplained_by(0);
    std::int64_t best_ns = 0;
    double least = as_is;
    for (std::int64_t ahead = -kFarthest_ns; ahead <= kFarthest_ns; ahead += kClockStep_ns) {
      const double left = unexplained_by(ahead);
      if (left < least) best_ns = ahead;
      least = std::min(least, left);
    }
    const bool is_clear = least < (1.0 - kLeastGain) * as_is && least < 0.5 * spread;
    return is_clear && std::abs(best_ns) > kClockStep_ns ? best_ns : 0;
  }

 private:
  static constexpr std::int64_t kFarthest_ns = kSecond_ns / 2;
  static constexpr std::int64_t kClockStep_ns = 20'000'000;
  static constexpr std::size_t kLeastCompared = 20;
  static constexpr double kLeastSpread_m2_s2 = 0.04;  // noise of a step's speed is 0.1 m/s
  static constexpr double kLeastGain = 0.2;           // as for turn rates

  struct Compared {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    double time_s = 0.0;
    double speed_m_s = 0.0;  // by the scans
  };

  // Mean square of what is left of the speeds by scans without their best multiple of others.
  template <class Speed>
  [[nodiscard]] double unexplained(const Speed& speed_of) const {
    double both = 0.0;
    double own = 0.0;
    double all = 0.0;
    for (const Compared& step : compared_) {
      const double other = speed_of(step);
      both += other * step.speed_m_s;
      own += other * other;
      all += step.speed_m_s * step.speed_m_s;
    }
    if (own == 0.0) return 0.0;
    return (all - both * both / own) / static_cast<double>(compared_.size());
  }
  [[nodiscard]] double unexplained_by(std::int64_t ahead_ns) const {
    return unexplained([&](const Compared& step) {
      return *sensors_.wheel_way_m(step.from_ns + ahead_ns, step.to_ns + ahead_ns) / step.time_s;
    });
  }

  const MotionSensors& sensors_;
  std::vector<Compared> compared_;
};

// The drive with the wheels on the clock of the scans.
Drive with_wheels_moved(Drive drive, std::int64_t ahead_ns) {
  for (WheelSpeed& speed : drive.wheel_speeds) speed.stamp_ns -= ahead_ns;
  return drive;
}

// All steps of an odometry; `speed` has followed them.
std::vector<SensedStep> sensed_steps(const Drive& drive, const Odometry& odometry,
                                     SpeedForecast& speed) {
  std::vector<SensedStep> steps(odometry.T_map_lidar.size());
  for (std::size_t k = 1; k < steps.size(); ++k) {
    if (odometry.piece[k] != odometry.piece[k - 1]) continue;
    const ScanStep step = scan_step(drive, odometry, k);
    speed.take(step, odometry.constraint[k].weak[0] == 0.0);
    const Pose T_from_to = step.T_map_from.inverse() * step.T_map_to;
    steps[k] = {speed.ahead(), speed.ahead().dot(T_from_to.translation()),
                speed.sensors()->wheel_way_m(step.from_ns, step.to_ns),
                speed.sensors()->gain(step, speed.ahead())};
  }
  return steps;
}

// Moves the steps with another way, and all poses behind.
void move_steps(const std::vector<SensedStep>& steps,
                const std::vector<std::optional<SmoothedWay>>& ways, Odometry& odometry) {
  const std::vector<Pose> before = odometry.T_map_lidar;
  double longer_m = 0.0;
  for (std::size_t k = 1; k < before.size(); ++k) {
    Pose step = before[k - 1].inverse() * before[k];
    const double old_m = step.translation().norm();
    if (ways[k]) {
      const double weak = odometry.constraint[k].weak[0];
      const double off_m = ways[k]->way_m - steps[k].way_m;
      step.translation() += weak * weak * off_m * steps[k].ahead;
      odometry.constraint[k].way_share = ways[k]->share;
    }
    longer_m += step.translation().norm() - old_m;
    odometry.T_map_lidar[k] = tidied(odometry.T_map_lidar[k - 1] * step);
    odometry.driven_m[k] += longer_m;
  }
}

std::vector<std::optional<SmoothedWay>> smoothed_ways(const std::vector<SensedStep>& steps,
                                                      const Odometry& odometry,
                                                      const WheelScale& wheels) {
  std::vector<std::optional<SmoothedWay>> ways(steps.size());
  for (std::size_t k = 1; k < steps.size(); ++k) {
    if (!steps[k].wheel_way_m || !is_forecast_by(odometry.constraint[k], Forecast::kWheels)) {
      continue;
    }
    ways[k] = SmoothedWay{wheels.way_per_wheel() * *steps[k].wheel_way_m, wheels.sigma()};
  }
  for (const ScanRange& run : inertial_runs(steps, odometry)) {
    InertialRun(steps, odometry, run.begin, run.end).smooth(ways);
  }
  return ways;
}

}  // namespace

void smooth_forecasts(const PassContext& ctx, const Drive& drive, Odometry& odometry) {
  SpeedForecast speed(drive);
  if (speed.sensors() == nullptr) return;
  std::vector<SensedStep> steps = sensed_steps(drive, odometry, speed);
  const std::int64_t ahead_ns = WheelClock(drive, odometry, steps, *speed.sensors()).ahead_ns();
  if (ahead_ns != 0) {
    ctx.warn(
        fmt::format("drive {}: the clock of the wheel speeds is {:.2f} s {} that of the scans; "
                    "their times are corrected",
                    drive.name, std::abs(1e-9 * static_cast<double>(ahead_ns)),
                    ahead_ns > 0 ? "ahead of" : "behind"));
    speed = SpeedForecast(with_wheels_moved(drive, ahead_ns));
    steps = sensed_steps(drive, odometry, speed);
  }
  const std::vector<std::optional<SmoothedWay>> ways =
      smoothed_ways(steps, odometry, speed.wheels());
  if (speed.wheels().is_contradicted()) {
    ctx.warn(
        fmt::format("drive {}: most wheel speeds differ by more than 10 % from the motion that "
                    "the scans show; they are not used. Check the topic and its unit (m/s), or "
                    "set wheel_speed to none",
                    drive.name));
  }
  const bool is_changed =
      std::ranges::any_of(ways, [](const auto& way) { return way.has_value(); });
  if (is_changed) move_steps(steps, ways, odometry);
}

}  // namespace sightline
