#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "examples/ros2/core/scan_matcher.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/replay/replayed_scan.h"

// The node that takes the place of ndt_scan_matcher, driven by a recording without ROS: each scan
// is preceded by the poses of a filter that follows the node's own poses at constant speed.

namespace sightline {

struct NodeReplayOptions {
  std::string map_file;
  double limit_m = 0.10;
  bool holds_whole_map = false;
  Pose T_world_start = Pose::Identity();  // of the first scan, right to 1 m; any heading
};

struct NodeScan {
  bool has_pose = false;
  Pose T_world_vehicle = Pose::Identity();
  double exe_time_ms = 0.0;
  std::uint32_t integrity = 0;
  sightline_match match{};
  std::string message;  // of the scan's diagnostics
};

// One result a scan. The motion within a scan is corrected, as nodes before this one do. Errors:
// those of opening the map and of reading a scan; no-overlap where the start is not found.
Result<std::vector<NodeScan>> replay_in_node(const NodeReplayOptions& options,
                                             const ScanStore& store,
                                             const std::vector<ListedScan>& scans,
                                             const SensorProfile& sensor);

}  // namespace sightline
