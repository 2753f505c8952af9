#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/foreign/logs/scan_container.h"
#include "formats/foreign/text/pose_file.h"

namespace sightline {

// Whether a file begins like a ROS 1 bag.
bool is_ros_bag(const std::filesystem::path& path);

struct BagTopic {
  std::string name;
  std::string type;  // "sensor_msgs/PointCloud2"
  std::size_t message_count = 0;
};

// What a ROS 1 bag holds, by name. Errors: cannot-read, malformed-header.
Result<std::vector<BagTopic>> list_bag_topics(const std::filesystem::path& path);

// The poses of one topic of a ROS 1 bag (see is_pose_message; empty: the only such topic), in order
// of their stamps. Errors: cannot-open, malformed-header, unsupported-format, unknown-name,
// bad-value, time-runs-backwards, and those of parse_pose_message.
Result<std::vector<PoseRow>> read_bag_poses(const std::filesystem::path& path,
                                            const std::string& topic);

// The scans of one topic (sensor_msgs/PointCloud2) of a ROS 1 bag; errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_bag(const std::filesystem::path& path,
                                                      const std::string& topic);

}  // namespace sightline
