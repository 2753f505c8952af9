#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>

#include "examples/town/drive/drive.h"
#include "formats/base/result.h"

namespace sightline::town {

// A drive that is swept as a vehicle records it: an MCAP file with messages of ROS 1, in chunks of
// none, on the clock of a September day:
//   /points     sensor_msgs/PointCloud2, frame lidar: x y z intensity, t in ns after the stamp
//   /odom       nav_msgs/Odometry, the poses given, one at the stamp of each scan
//   /imu        sensor_msgs/Imu, frame imu, which lies on its side: see imu_of
//   /tf_static  where both sit in base_link
// and where the drive has motion sensors
//   /imu          with linear accelerations: see specific_forces
//   /wheel_speed  geometry_msgs/TwistStamped, frame base_link: see wheel_speeds
// The same bytes for any number of threads. Errors: cannot-write, disk-full.
struct BagOptions {
  std::uint64_t seed = 0;  // of the inertial unit's errors
  Eigen::Vector2d origin_world_m = Eigen::Vector2d::Zero();
  int threads = 0;
  bool has_motion = false;  // accelerations, and the speed of the wheels
};
Result<void> write_bag(const std::filesystem::path& path, const DriveSimulator& drive,
                       std::span<const Pose> poses, const BagOptions& options);

}  // namespace sightline::town
