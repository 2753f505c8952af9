#pragma once

#include <chrono>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <map>
#include <rclcpp/rclcpp.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tf2 {

using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::system_clock, Duration>;

class TransformException : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What the test publishes, by target and source, and what nodes sent.
struct Recorded {
  std::map<std::pair<std::string, std::string>, geometry_msgs::msg::TransformStamped> known;
  std::vector<geometry_msgs::msg::TransformStamped> sent;
};
inline Recorded& recorded() {
  static Recorded all;
  return all;
}

}  // namespace tf2

namespace tf2_ros {

class Buffer {
 public:
  explicit Buffer(rclcpp::Clock::SharedPtr) {}
  geometry_msgs::msg::TransformStamped lookupTransform(const std::string& target,
                                                       const std::string& source,
                                                       const tf2::TimePoint&,
                                                       const tf2::Duration) const {
    const auto found = tf2::recorded().known.find({target, source});
    if (found == tf2::recorded().known.end()) {
      throw tf2::TransformException('"' + source + "\" does not exist");
    }
    return found->second;
  }
};

}  // namespace tf2_ros
