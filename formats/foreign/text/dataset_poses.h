#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/geometry.h"

namespace sightline {

// Where KITTI's poses are those of, seen from the laser scanner.
struct KittiCalibration {
  Pose T_posed_lidar = Pose::Identity();  // posed: the left camera, or the inertial unit
  // Poses of the camera are in axes of its first pose, where z points forward: the world is
  // then turned to those of the scanner at its first pose.
  bool is_of_camera = false;
};

// calib.txt of the odometry benchmark ("Tr: " and 12 numbers), calib_velo_to_cam.txt and
// calib_imu_to_velo.txt of the raw recordings ("R: " and 9, "T: " and 3). Errors: file-not-found,
// cannot-read, too-large, missing-field, malformed-text, not-a-rotation.
Result<KittiCalibration> read_kitti_calibration(const std::filesystem::path& path);
// The same of what the file holds.
Result<KittiCalibration> parse_kitti_calibration(std::string_view text,
                                                 const std::filesystem::path& path);

// The scanner's pose in the world from a pose of the file.
Pose lidar_pose(const KittiCalibration& calibration, const Pose& T_world_posed);

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
