#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/foreign/ros/files/mcap_writer.h"
#include "formats/geometry.h"

// Messages of ROS 2 as rosbag2 records them, and as Foxglove shows them.

namespace sightline {

// A geometry_msgs/msg/PoseWithCovarianceStamped. Its covariance is that of ROS: x y z and turns
// about the axes of the frame, row by row.
using Covariance = Eigen::Matrix<double, 6, 6>;
extern const McapType kPoseWithCovarianceStamped;
std::vector<std::byte> pose_message(std::int64_t stamp_ns, std::string_view frame,
                                    const Pose& T_frame_vehicle, const Covariance& covariance);

// A nav_msgs/msg/Path: a line through poses.
struct StampedPose {
  std::int64_t stamp_ns = 0;
  Pose T_frame_vehicle = Pose::Identity();
};
extern const McapType kPath;
std::vector<std::byte> path_message(std::string_view frame, std::span<const StampedPose> poses);

// A diagnostic_msgs/msg/DiagnosticArray with one status.
enum class StatusLevel : std::uint8_t { kOk, kWarning, kError };
struct Status {
  StatusLevel level = StatusLevel::kOk;
  std::string name;
  std::string message;
  std::string hardware;
  std::vector<std::pair<std::string, std::string>> values;
};
extern const McapType kDiagnosticArray;
std::vector<std::byte> status_message(std::int64_t stamp_ns, std::string_view frame,
                                      const Status& status);

}  // namespace sightline
