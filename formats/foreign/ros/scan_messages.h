#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/ros/files/open_message_log.h"

namespace sightline {

// Types of messages that hold a scan: sensor_msgs/PointCloud2, livox_ros_driver2/CustomMsg (of its
// first driver too), velodyne_msgs/VelodyneScan.
bool is_scan_message(std::string_view datatype);

inline constexpr std::string_view kPointCloud2 = "sensor_msgs/PointCloud2";

// The points of a sensor_msgs/PointCloud2: any order of fields and types, both byte orders, rows
// with padding; intensity and times as in other formats. Errors: malformed-header, missing-field,
// truncated-scan, empty-scan; the place is a byte of the message.
Result<PointCloudFile> parse_point_cloud2(std::span<const std::byte> message,
                                          const std::string& file,
                                          MessageEncoding encoding = MessageEncoding::kRos1);

// The points of a message of one of these types. Livox: times as the message has them. Velodyne:
// the packets of a VLP-16 or HDL-32E, each at its own stamp. Errors: malformed-header,
// missing-field, truncated-scan, empty-scan, unsupported-format (packets of another model); the
// place is a byte of the message.
Result<PointCloudFile> parse_scan_message(std::span<const std::byte> message,
                                          std::string_view datatype, const std::string& file,
                                          MessageEncoding encoding);

}  // namespace sightline
