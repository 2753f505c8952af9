#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Whether open_scan_container is the one to ask: a bag of ROS 1 or ROS 2 or a pcap,
// by its first bytes.
bool is_scan_container(const std::filesystem::path& path);

// Opens a bag of ROS 1 or ROS 2 (scans of `topic`, see is_scan_message; empty: the only such topic)
// or a pcap of a Velodyne, Hesai or Ouster (open_capture, which takes `sensor`; `topic` must be
// empty).
// Errors: cannot-open, cannot-read, malformed-header, truncated-scan, unsupported-format,
// unknown-name (a topic that is not there), bad-value (several topics to choose from),
// time-runs-backwards, drive-too-short, and those of open_capture.
Result<std::shared_ptr<const ScanContainer>> open_scan_container(
    const std::filesystem::path& path, const std::string& topic,
    const std::filesystem::path& sensor = {});

}  // namespace sightline
