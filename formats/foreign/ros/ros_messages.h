#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/ros/message_reader.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/pose_file.h"

// Messages of ROS 1 and ROS 2 with poses and points; their types are named as in ROS 1.

namespace sightline {

inline constexpr std::string_view kPointCloud2 = "sensor_msgs/PointCloud2";

// nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped or TransformStamped.
bool is_pose_message(std::string_view datatype);

// tf2_msgs/TFMessage, or tf/tfMessage of older recordings.
bool is_transforms_message(std::string_view datatype);

// Of a message that begins with a std_msgs/Header. Error: malformed-header.
Result<MessageHeader> header_of(std::span<const std::byte> message, MessageEncoding encoding,
                                const std::string& file);

// The points of a sensor_msgs/PointCloud2: any order of fields and types, both byte orders, rows
// with padding; intensity and times as in other formats. Errors: malformed-header, missing-field,
// truncated-scan, empty-scan; the place is a byte of the message.
Result<PointCloudFile> parse_point_cloud2(std::span<const std::byte> message,
                                          const std::string& file,
                                          MessageEncoding encoding = MessageEncoding::kRos1);

// The stamp and pose of a message of one of the types of is_pose_message. Errors:
// malformed-pose, not-a-rotation.
Result<PoseRow> parse_pose_message(std::span<const std::byte> message, std::string_view datatype,
                                   const std::string& file,
                                   MessageEncoding encoding = MessageEncoding::kRos1);

// sensor_msgs/NavSatFix: a place in degrees, height above the ellipsoid. Nothing where the receiver
// had no fix. Error: malformed-pose (short, or no place on Earth).
inline constexpr std::string_view kNavSatFix = "sensor_msgs/NavSatFix";
Result<std::optional<GeodeticFix>> parse_fix_message(std::span<const std::byte> message,
                                                     const std::string& file,
                                                     MessageEncoding encoding);

// sensor_msgs/Imu, of which only the angular velocity is read: about the axes of the header's
// frame, rad/s. Nothing where the message is short or not finite, says that it has none (its
// covariance begins with -1), or turns faster than 100 rad/s, which no unit on a vehicle measures.
inline constexpr std::string_view kImu = "sensor_msgs/Imu";
struct ImuMessage {
  MessageHeader header;
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
};
std::optional<ImuMessage> parse_imu_message(std::span<const std::byte> message,
                                            MessageEncoding encoding);

// One frame within another. Names are without a leading slash.
struct StampedTransform {
  std::int64_t stamp_ns = 0;
  std::string parent;
  std::string child;
  Pose T_parent_child = Pose::Identity();
};

// Those of a message of is_transforms_message. Errors: malformed-pose, not-a-rotation.
Result<std::vector<StampedTransform>> parse_transforms(std::span<const std::byte> message,
                                                       const std::string& file,
                                                       MessageEncoding encoding);

}  // namespace sightline
