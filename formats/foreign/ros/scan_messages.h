#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// Types of messages that hold a scan: sensor_msgs/PointCloud2, livox_ros_driver2/CustomMsg (of its
// first driver too), velodyne_msgs/VelodyneScan.
bool is_scan_message(std::string_view datatype);

// The points of a message of one of these types. Livox: times as the message has them. Velodyne:
// the packets of a VLP-16 or HDL-32E, each at its own stamp. Errors: malformed-header,
// missing-field, truncated-scan, empty-scan, unsupported-format (packets of another model); the
// place is a byte of the message.
Result<PointCloudFile> parse_scan_message(std::span<const std::byte> message,
                                          std::string_view datatype, const std::string& file,
                                          MessageEncoding encoding);

}  // namespace sightline
