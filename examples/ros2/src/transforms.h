#pragma once

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/poses.h"

namespace sightline_ros2 {

// The transforms that other nodes publish, and those of this one.
class Transforms {
 public:
  template <class NodeT>
  explicit Transforms(NodeT& node)
      : buffer_(node.get_clock()), listener_(buffer_), broadcaster_(node) {}

  // Takes coordinates in `source` to `target`: at that time, or the latest where it is 0. None
  // where it is not known; `fault` then is why. Waits up to 50 ms for one of a time.
  std::optional<PoseRows> find(const std::string& target, const std::string& source,
                               std::int64_t stamp_ns, std::string& fault);
  void send(std::int64_t stamp_ns, const std::string& parent, const std::string& child,
            const Pose& pose);

 private:
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace sightline_ros2
