#include "passes/trajectory/following/unconstrained.h"

#include <fmt/format.h>

#include <algorithm>

#include "passes/trajectory/local/scan_constraint.h"

namespace sightline {
namespace {

// 0.1 rad over 100 m: a bend of a road that nothing shows.
constexpr double kDrift_rad_per_m = 0.001;
constexpr double kLongestGap_m = 5.0;
constexpr double kLeastWay_m = 10.0;
constexpr std::uint32_t kLeastScans = 10;
// An axis is named where so much of it is not constrained.
constexpr double kNamed = 0.5;

bool is_weak(const StepConstraint& step) { return !step.weak.isZero(0.0); }

double step_m(const Odometry& odometry, std::size_t k) {
  return k == 0 ? 0.0 : odometry.driven_m[k] - odometry.driven_m[k - 1];
}

bool is_long(const WeakSteps& steps) {
  return steps.way_m >= kLeastWay_m ||
         (steps.forecast == Forecast::kNone && steps.last - steps.first + 1 >= kLeastScans);
}

Substitute substitute_of(Forecast forecast) {
  switch (forecast) {
    case Forecast::kGiven:
      return Substitute::kGivenPoses;
    case Forecast::kSteady:
      return Substitute::kConstantSpeed;
    case Forecast::kWheels:
      return Substitute::kWheelSpeed;
    case Forecast::kInertial:
      return Substitute::kInertial;
    case Forecast::kNone:
      break;
  }
  return Substitute::kNone;
}

Unconstrained unconstrained_of(const WeakSteps& steps) {
  const double least = std::min(kNamed, steps.weak.maxCoeff());
  return {steps.weak[0] >= least, steps.weak[1] >= least, steps.weak[2] >= least,
          substitute_of(steps.forecast)};
}

// What one unknown number, of standard deviation 1, does to a pose.
using Effect = Vector6d;

// The unknown speed and drift of a stretch of weak steps.
struct ForecastErrors {
  Effect speed = Effect::Zero();
  Effect drift = Effect::Zero();

  // A step of the way: poses behind a wrong heading move aside.
  void carry(const Eigen::Vector3d& way_m) {
    for (Effect* effect : {&speed, &drift}) {
      effect->head<3>() += Eigen::Vector3d(effect->tail<3>()).cross(way_m);
    }
  }
  void add(const Eigen::Vector3d& way_m, const StepConstraint& step) {
    const double length_m = way_m.norm();
    speed.head<3>() += step.way_share * step.weak[0] * way_m;
    drift[5] += kDrift_rad_per_m * step.weak[2] * length_m;
    const Eigen::Vector3d left_m = Eigen::Vector3d::UnitZ().cross(way_m);
    drift.head<3>() += 0.5 * kDrift_rad_per_m * step.weak[1] * length_m * left_m;
  }
};

}  // namespace

std::vector<WeakSteps> weak_steps(const Odometry& odometry) {
  std::vector<WeakSteps> all;
  double last_m = 0.0;  // of the way, at the last weak step
  std::uint32_t count = 0;
  for (std::uint32_t k = 1; k < odometry.constraint.size(); ++k) {
    const StepConstraint& step = odometry.constraint[k];
    if (!is_weak(step)) continue;
    const bool goes_on = !all.empty() && all.back().forecast == step.forecast &&
                         odometry.piece[k] == odometry.piece[all.back().last] &&
                         odometry.driven_m[k - 1] - last_m <= kLongestGap_m;
    if (!goes_on) {
      all.push_back({k, k, 0.0, Eigen::Vector3d::Zero(), step.forecast});
      count = 0;
    }
    WeakSteps& steps = all.back();
    steps.last = k;
    steps.way_m += step_m(odometry, k);
    steps.weak += (step.weak - steps.weak) / ++count;
    last_m = odometry.driven_m[k];
  }
  std::erase_if(all, [](const WeakSteps& steps) { return !is_long(steps); });
  return all;
}

void mark_unconstrained(const Odometry& odometry, std::vector<TrajectoryPose>& poses) {
  for (const WeakSteps& steps : weak_steps(odometry)) {
    const Unconstrained directions = unconstrained_of(steps);
    for (std::uint32_t k = steps.first; k <= steps.last; ++k) poses[k].unconstrained = directions;
  }
}

void warn_of_unconstrained(const PassContext& ctx, const std::string& drive,
                           const Trajectory& trajectory) {
  constexpr std::size_t kMostNamed = 5;
  std::string text;
  std::size_t count = 0;
  for (const UnconstrainedStretch& stretch : unconstrained_stretches(trajectory)) {
    if (stretch.directions.substitute == Substitute::kGivenPoses) continue;
    if (++count <= kMostNamed) text += (count == 1 ? "" : "; ") + to_text(stretch);
  }
  if (count == 0) return;
  ctx.warn(
      fmt::format("drive {}: the scans do not constrain the vehicle on {} stretch{} of the "
                  "way: {}{}. Give poses, wheel speed or an IMU to know its motion there",
                  drive, count, count == 1 ? "" : "es", text, count > kMostNamed ? "; ..." : ""));
}

std::vector<Matrix6d> forecast_covariance(const Odometry& odometry,
                                          const std::vector<Pose>& T_map_lidar,
                                          const Pose& T_lidar_vehicle) {
  std::vector<Matrix6d> covariance(T_map_lidar.size(), Matrix6d::Zero());
  std::vector<ForecastErrors> stretches;  // of the piece
  bool goes_on = false;
  for (std::size_t k = 1; k < T_map_lidar.size(); ++k) {
    if (odometry.piece[k] != odometry.piece[k - 1]) {
      stretches.clear();
      goes_on = false;
      continue;
    }
    const StepConstraint& step = odometry.constraint[k];
    const bool is_forecast =
        is_weak(step) && step.forecast != Forecast::kGiven && step.forecast != Forecast::kNone;
    if (is_forecast && !goes_on) stretches.emplace_back();
    goes_on = is_forecast;
    const Eigen::Vector3d way_m = (T_map_lidar[k] * T_lidar_vehicle).translation() -
                                  (T_map_lidar[k - 1] * T_lidar_vehicle).translation();
    for (ForecastErrors& errors : stretches) errors.carry(way_m);
    if (is_forecast) stretches.back().add(way_m, step);
    for (const ForecastErrors& errors : stretches) {
      covariance[k] += errors.speed * errors.speed.transpose();
      covariance[k] += errors.drift * errors.drift.transpose();
    }
  }
  return covariance;
}

}  // namespace sightline
