#include "passes/trajectory/following/unconstrained.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "passes/trajectory/local/scan_constraint.h"

namespace sightline {
namespace {

// 0.1 rad over 100 m: a bend of a road that nothing shows.
constexpr double kDrift_rad_per_m = 0.001;
// Of an assumed speed, a part of the error lasts all along a stretch, the rest changes after so
// much of the way: drivers change their speed by some percent within 20 s. In a curve such an error
// is not along one line.
constexpr double kLastingShare = 0.7;
constexpr double kSpeedPart_m = 50.0;
constexpr double kLongestGap_m = 5.0;
constexpr double kLeastWay_m = 10.0;
constexpr std::uint32_t kLeastScans = 10;
// An axis is named where surfaces leave more of an error than this, by the median over so much of
// the way to either side: noise of single scans is more than the difference of such places.
constexpr double kLeft[] = {0.12, 0.3, 0.3};
constexpr double kMedianReach_m = 8.0;
constexpr std::size_t kMostMedianScans = 100;  // to either side
// A leap is along an axis by more than this share of it.
constexpr double kLeapsAlong = 0.5;

bool is_weak(const StepConstraint& step) { return !step.weak.isZero(0.0); }

bool leaps(const StepConstraint& step, int axis) {
  return axis < 2 && std::abs(step.leap_m[axis]) > kLeapsAlong * step.leap_m.norm();
}

bool is_long(const WeakSteps& steps) {
  return steps.has_leap || steps.way_m >= kLeastWay_m ||
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

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Whether surfaces leave more than the limit of an error along the axis, around each step.
std::vector<bool> are_left(const Odometry& odometry, int axis) {
  const std::size_t count = odometry.constraint.size();
  const auto is_near = [&](std::size_t a, std::size_t b) {
    return odometry.piece[a] == odometry.piece[b] &&
           std::max(a, b) - std::min(a, b) <= kMostMedianScans &&
           std::abs(odometry.driven_m[a] - odometry.driven_m[b]) <= kMedianReach_m;
  };
  std::vector<bool> are(count, false);
  std::vector<double> kept;
  for (std::size_t k = 1, begin = 1; k < count; ++k) {
    while (!is_near(begin, k)) ++begin;
    kept.clear();
    for (std::size_t i = begin; i < count && is_near(i, k); ++i) {
      kept.push_back(odometry.constraint[i].kept[axis]);
    }
    are[k] = median_of(kept) > kLeft[axis];
  }
  return are;
}

// Whether a step belongs to a stretch: near it, with the same forecast where both have one.
bool continues(const Odometry& odometry, const WeakSteps& steps, std::uint32_t k) {
  const StepConstraint& step = odometry.constraint[k];
  const bool is_other = is_weak(step) && step.forecast != steps.forecast;
  return !is_other && odometry.piece[k] == odometry.piece[steps.last] &&
         odometry.driven_m[k - 1] - odometry.driven_m[steps.last] <= kLongestGap_m;
}

std::vector<WeakSteps> weak_steps_along(const Odometry& odometry, int axis) {
  const std::vector<bool> are = are_left(odometry, axis);
  std::vector<WeakSteps> all;
  for (std::uint32_t k = 1; k < odometry.constraint.size(); ++k) {
    const bool has_leap = leaps(odometry.constraint[k], axis);
    const bool is_named = are[k] || has_leap;
    // A step that surfaces constrain, among others, begins none: it has no forecast.
    const bool begins = is_named && (is_weak(odometry.constraint[k]) || has_leap);
    if (is_named && !all.empty() && continues(odometry, all.back(), k)) {
      all.back().way_m += odometry.driven_m[k] - odometry.driven_m[all.back().last];
      all.back().last = k;
      all.back().has_leap = all.back().has_leap || has_leap;
    } else if (begins) {
      const double step_m = odometry.driven_m[k] - odometry.driven_m[k - 1];
      const Forecast forecast = has_leap ? Forecast::kSteady : odometry.constraint[k].forecast;
      all.push_back({axis, k, k, step_m, forecast, has_leap});
    }
  }
  std::erase_if(all, [](const WeakSteps& steps) { return !is_long(steps); });
  return all;
}

// What one unknown number, of standard deviation 1, does to a pose.
using Effect = Vector6d;

// What is unknown of the way up to a pose of a piece.
class ForecastErrors {
 public:
  // A step of the way: poses behind a wrong heading move aside.
  void carry(const Eigen::Vector3d& way_m) {
    for (Effect& effect : effects_) {
      effect.head<3>() += Eigen::Vector3d(effect.tail<3>()).cross(way_m);
    }
  }
  // A step that rests on a forecast: of a speed that is off all along the stretch, of one that is
  // off for a part of it, and of a heading that drifts.
  void add(const Eigen::Vector3d& way_m, const StepConstraint& step) {
    if (!is_in_stretch_) {
      stretch_ = begin();
      drift_ = begin();
    }
    if (!is_in_stretch_ || part_m_ >= kSpeedPart_m) {
      part_ = begin();
      part_m_ = 0.0;
    }
    is_in_stretch_ = true;
    const double length_m = way_m.norm();
    part_m_ += length_m;
    const Eigen::Vector3d unknown_m = step.way_share * step.weak[0] * way_m;
    const bool is_assumed = step.forecast == Forecast::kSteady;
    effects_[stretch_].head<3>() += (is_assumed ? kLastingShare : 1.0) * unknown_m;
    if (is_assumed) effects_[part_].head<3>() += unknown_m;
    Effect& drift = effects_[drift_];
    drift[5] += kDrift_rad_per_m * step.weak[2] * length_m;
    const Eigen::Vector3d left_m = Eigen::Vector3d::UnitZ().cross(way_m);
    drift.head<3>() += 0.5 * kDrift_rad_per_m * step.weak[1] * length_m * left_m;
  }
  void add_leap(const Pose& T_map_vehicle, const Eigen::Vector2d& leap_m) {
    effects_[begin()].head<3>() =
        T_map_vehicle.linear() * Eigen::Vector3d(leap_m.x(), leap_m.y(), 0.0);
    end_stretch();
  }
  void end_stretch() { is_in_stretch_ = false; }

  [[nodiscard]] Matrix6d covariance() const {
    Matrix6d sum = Matrix6d::Zero();
    for (const Effect& effect : effects_) sum += effect * effect.transpose();
    return sum;
  }

 private:
  std::size_t begin() {
    effects_.emplace_back(Effect::Zero());
    return effects_.size() - 1;
  }

  std::vector<Effect> effects_;
  bool is_in_stretch_ = false;
  double part_m_ = 0.0;      // of the way, of the part
  std::size_t stretch_ = 0;  // effects
  std::size_t part_ = 0;
  std::size_t drift_ = 0;
};

}  // namespace

std::vector<WeakSteps> weak_steps(const Odometry& odometry) {
  std::vector<WeakSteps> all;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<WeakSteps> along = weak_steps_along(odometry, axis);
    all.insert(all.end(), along.begin(), along.end());
  }
  return all;
}

void mark_unconstrained(const Odometry& odometry, std::vector<TrajectoryPose>& poses) {
  for (const WeakSteps& steps : weak_steps(odometry)) {
    for (std::uint32_t k = steps.first; k <= steps.last; ++k) {
      Unconstrained& named = poses[k].unconstrained;
      if (!named.is_any()) named.substitute = substitute_of(steps.forecast);
      named.along = named.along || steps.axis == 0;
      named.across = named.across || steps.axis == 1;
      named.heading = named.heading || steps.axis == 2;
    }
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
  ForecastErrors errors;  // of the piece
  for (std::size_t k = 1; k < T_map_lidar.size(); ++k) {
    if (odometry.piece[k] != odometry.piece[k - 1]) {
      errors = {};
      continue;
    }
    const StepConstraint& step = odometry.constraint[k];
    const bool is_forecast =
        is_weak(step) && step.forecast != Forecast::kGiven && step.forecast != Forecast::kNone;
    const Pose T_map_before = T_map_lidar[k - 1] * T_lidar_vehicle;
    const Eigen::Vector3d way_m =
        (T_map_lidar[k] * T_lidar_vehicle).translation() - T_map_before.translation();
    errors.carry(way_m);
    if (is_forecast) {
      errors.add(way_m, step);
    } else {
      errors.end_stretch();
    }
    if (!step.leap_m.isZero(0.0)) errors.add_leap(T_map_before, step.leap_m);
    covariance[k] = errors.covariance();
  }
  return covariance;
}

}  // namespace sightline
