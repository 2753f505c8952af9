#include "passes/trajectory/following/steady_motion.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr std::size_t kLeastSteps = 5;
constexpr std::size_t kMostSteps = 10;
// Even motion is extended to at most so many times the step that it was measured on.
constexpr double kMostTimes = 10.0;

}  // namespace

Pose carried_on(const TimedStep& step, std::int64_t time_ns) {
  if (step.time_ns <= 0 || time_ns == step.time_ns) return step.T_before_after;
  const double share =
      std::clamp(static_cast<double>(time_ns) / static_cast<double>(step.time_ns), 0.0, kMostTimes);
  const AxisAngle turn = axis_angle(step.T_before_after.linear());
  const Eigen::Matrix3d half_more =
      rotation_matrix({turn.axis, 0.5 * (share - 1.0) * turn.angle_rad});
  Pose longer = Pose::Identity();
  longer.linear() = rotation_matrix({turn.axis, share * turn.angle_rad});
  longer.translation() = share * (half_more * step.T_before_after.translation());
  return longer;
}

void SteadyMotion::add(const TimedStep& step) {
  if (step.time_ns <= 0) return;
  steps_.push_back(step);
  if (steps_.size() > kMostSteps) steps_.pop_front();
}

bool SteadyMotion::is_known() const { return steps_.size() >= kLeastSteps; }

Pose SteadyMotion::step(std::int64_t time_ns) const {
  TimedStep mean;
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d turned_rad = Eigen::Vector3d::Zero();
  for (const TimedStep& step : steps_) {
    moved_m += step.T_before_after.translation();
    turned_rad += rotation_vector(step.T_before_after.linear());
    mean.time_ns += step.time_ns;
  }
  const double count = static_cast<double>(steps_.size());
  mean.time_ns /= static_cast<std::int64_t>(steps_.size());
  mean.T_before_after.translation() = moved_m / count;
  const double angle_rad = turned_rad.norm() / count;
  if (angle_rad > 0.0) {
    mean.T_before_after.linear() = rotation_matrix({turned_rad.normalized(), angle_rad});
  }
  return carried_on(mean, time_ns);
}

}  // namespace sightline
