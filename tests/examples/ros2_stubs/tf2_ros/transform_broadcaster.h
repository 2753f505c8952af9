#pragma once

#include <tf2_ros/buffer.h>

namespace tf2_ros {

class TransformBroadcaster {
 public:
  template <class NodeT>
  explicit TransformBroadcaster(NodeT&&) {}
  void sendTransform(const geometry_msgs::msg::TransformStamped& transform) {
    tf2::recorded().sent.push_back(transform);
  }
};

}  // namespace tf2_ros
