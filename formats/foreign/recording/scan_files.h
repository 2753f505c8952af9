#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/scan_container.h"

namespace sightline {

// Runs of digits compare as numbers, so that 2 comes before 10; ties by plain text.
bool natural_less(std::string_view a, std::string_view b);

// The scans of a folder in natural order: files with a readable ending (is_scan_ending), all
// of one kind. Hidden files and files of other kinds are no scans.
// Errors: file-not-found (no such folder, or a link among the scans leads nowhere), cannot-open,
// cannot-read (no regular file), empty-directory, mixed-formats, unsupported-format (also of a file
// in place of the folder; says how to convert it).
Result<std::vector<std::filesystem::path>> list_scan_files(const std::filesystem::path& folder);

// The last run of digits in a scan's name ("scan_000012.pcd": 12), or nothing.
std::optional<std::int64_t> scan_number(const std::filesystem::path& file);

// The time that a scan's name is ("1567410201745204736.pcd", "1567410201.745204.bin"), or nothing.
std::optional<std::int64_t> scan_stamp_ns(const std::filesystem::path& file);

// Whether a path is a bag of ROS 1 or ROS 2 or a pcap, by its first bytes.
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
