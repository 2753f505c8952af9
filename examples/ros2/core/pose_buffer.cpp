#include "pose_buffer.h"

#include <cmath>

namespace sightline_ros2 {

void PoseBuffer::add(const StampedPose& pose) {
  if (!poses_.empty() && pose.stamp_ns < poses_.back().stamp_ns) poses_.clear();
  if (!poses_.empty() && pose.stamp_ns == poses_.back().stamp_ns) poses_.pop_back();
  poses_.push_back(pose);
}

std::optional<PoseAtTime> PoseBuffer::at(std::int64_t stamp_ns) {
  while (poses_.size() > 2 && poses_[1].stamp_ns <= stamp_ns && poses_[2].stamp_ns <= stamp_ns) {
    poses_.pop_front();
  }
  if (poses_.size() < 2 || poses_.front().stamp_ns > stamp_ns) return std::nullopt;
  const bool is_second = poses_.size() > 2 && poses_[1].stamp_ns <= stamp_ns;
  const StampedPose& before = poses_[is_second ? 1 : 0];
  const StampedPose& after = poses_[is_second ? 2 : 1];
  const auto is_far_off = [&](const StampedPose& pose) {
    return !(std::abs(static_cast<double>(pose.stamp_ns - stamp_ns)) * 1e-9 < timeout_s_);
  };
  if (is_far_off(before) || is_far_off(after)) return std::nullopt;
  if (!(distance_m(before.pose.position_m, after.pose.position_m) < most_apart_m_)) {
    return std::nullopt;
  }
  const bool is_ahead = stamp_ns >= after.stamp_ns;
  PoseAtTime found{is_ahead ? after : before, is_ahead ? after : before, after};
  found.pose.stamp_ns = stamp_ns;
  if (stamp_ns != found.before.stamp_ns) {
    const double share = static_cast<double>(stamp_ns - before.stamp_ns) /
                         static_cast<double>(after.stamp_ns - before.stamp_ns);
    found.pose.pose = interpolated(before.pose, after.pose, share);
  }
  return found;
}

}  // namespace sightline_ros2
