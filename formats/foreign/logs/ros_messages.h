#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/pose_file.h"

// ROS 1 messages as they are serialized: fields one after the other, little-endian, strings and
// arrays behind a 32-bit length.

namespace sightline {

inline constexpr std::string_view kPointCloud2 = "sensor_msgs/PointCloud2";

// nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped.
bool is_pose_message(std::string_view datatype);

// The stamp of a message that begins with a std_msgs/Header. Error: malformed-header.
Result<std::int64_t> header_stamp_ns(std::span<const std::byte> message, const std::string& file);

// The points of a sensor_msgs/PointCloud2: any order of fields and types, both byte orders, rows
// with padding; intensity and times as in other formats. Errors: malformed-header, missing-field,
// truncated-scan, empty-scan; the place is a byte of the message.
Result<PointCloudFile> parse_point_cloud2(std::span<const std::byte> message,
                                          const std::string& file);

// The stamp and pose of a message of one of the types of is_pose_message. Errors:
// malformed-pose, not-a-rotation.
Result<PoseRow> parse_pose_message(std::span<const std::byte> message, std::string_view datatype,
                                   const std::string& file);

}  // namespace sightline
