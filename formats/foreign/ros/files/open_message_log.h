#pragma once

#include <filesystem>
#include <memory>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

// Whether open_message_log is the one to ask, by the first bytes: a ROS 1 bag, an MCAP file, a .db3
// of rosbag2 or the folder with its metadata.yaml.
bool is_message_log(const std::filesystem::path& path);

// Opens one of them. The files of a folder are one recording in the order of its metadata; messages
// of ROS 2 that are packed one by one (zstd) are given unpacked. Errors: those of MessageLog;
// file-not-found, cannot-open.
Result<std::unique_ptr<MessageLog>> open_message_log(const std::filesystem::path& path);

}  // namespace sightline
