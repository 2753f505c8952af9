#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// "sensor_msgs/PointCloud2" for "sensor_msgs/msg/PointCloud2"; all others as they are.
inline std::string ros1_type_name(std::string_view type) {
  constexpr std::string_view kMiddle = "/msg/";
  const std::size_t at = type.find(kMiddle);
  if (at == std::string_view::npos) return std::string(type);
  return std::string(type.substr(0, at + 1)).append(type.substr(at + kMiddle.size()));
}

// "cdr" or "ros1", as MCAP and rosbag2 name them; nothing for any other.
inline std::optional<MessageEncoding> encoding_named(std::string_view name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  if (name == "ros1") return MessageEncoding::kRos1;
  return std::nullopt;
}

}  // namespace sightline
