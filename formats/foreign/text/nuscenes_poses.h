#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "formats/foreign/text/pose_file.h"

namespace sightline {

// nuScenes' table ego_pose.json: a list of objects with `timestamp` in microseconds, `rotation`
// (w x y z) and `translation`. Poses of the vehicle, ascending by time, each time once. Errors:
// file-not-found, cannot-read, malformed-text (no such list), malformed-pose, not-a-rotation.
Result<std::vector<PoseRow>> read_nuscenes_poses(const std::filesystem::path& path);
// The same of what the file holds.
Result<std::vector<PoseRow>> parse_nuscenes_poses(std::string_view text,
                                                  const std::filesystem::path& path);

// By its ending, .json.
bool is_nuscenes_poses(const std::filesystem::path& path);

}  // namespace sightline
