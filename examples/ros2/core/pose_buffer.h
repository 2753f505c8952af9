#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "poses.h"

namespace sightline_ros2 {

// Poses around a time, and the pose at that time.
struct PoseAtTime {
  StampedPose pose;    // its covariance is that of `before`
  StampedPose before;  // the last one that is not later; `after` where the filter is behind
  StampedPose after;
};

// The last poses of a filter, in the order of their times.
class PoseBuffer {
 public:
  PoseBuffer(double timeout_s, double most_apart_m)
      : timeout_s_(timeout_s), most_apart_m_(most_apart_m) {}

  // A time before the last one empties the buffer first: a recording that begins again. One of the
  // same time replaces it.
  void add(const StampedPose& pose);
  void clear() { poses_.clear(); }

  // Between the two poses around that time, or from the last two where the filter is behind the
  // scan. Removes what no later time needs. None where there are fewer than two poses, all are
  // later, one of the two is as far off as the timeout, or they are too far apart.
  std::optional<PoseAtTime> at(std::int64_t stamp_ns);

 private:
  double timeout_s_;
  double most_apart_m_;
  std::deque<StampedPose> poses_;
};

}  // namespace sightline_ros2
