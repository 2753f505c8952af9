#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "passes/map/build_ndt.h"
#include "passes/replay/replayed_scan.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/box_world.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

// A street with its map and a drive through it, for the nodes of examples/ros2.

namespace sightline {

struct RosStreet {
  std::string map_file;
  TestDrive test;
  MapFrame frame;

  [[nodiscard]] Pose truth_world(std::size_t scan) const {
    return rebase(test.truth.poses[scan].T_map_vehicle, frame, MapFrame{});
  }
  // In the frame of ROS: without the whole 100 km of the world.
  [[nodiscard]] Pose truth_map(std::size_t scan) const {
    const MapReader map = value_of(MapReader::open(map_file, ""));
    const Eigen::Vector3d origin_m =
        Eigen::Map<const Eigen::Vector3d>(map.info().export_origin_world_m.data());
    return Eigen::Translation3d(-origin_m) * truth_world(scan);
  }
  [[nodiscard]] std::vector<ListedScan> listed() const {
    std::vector<ListedScan> scans;
    for (const TrajectoryPose& pose : test.truth.poses) {
      scans.push_back({pose.stamp_ns, std::to_string(scans.size()), std::nullopt});
    }
    return scans;
  }
};

// 24 scans, 0.4 m and 0.1 s apart. Of each place the map names every return within 30 or 50 m.
inline const RosStreet& ros_street() {
  static const RosStreet kStreet = [] {
    RosStreet street;
    CompiledMap map = random_map(
        {.seed = 1, .site_count = 36, .run_count = 1, .ranges_m = {30.0, 50.0}, .looks = {}});
    const BoxWorld world = random_street(20);
    std::vector<Eigen::Vector3d> points_m;
    for (std::size_t i = 0; i < 36; ++i) {
      const Pose T_map_lidar = lidar_at(static_cast<double>(i) - 4.0, 0.0, 0.0);
      map.sites.sites[i].p_map_m = T_map_lidar.translation();
      for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 1.0).points_m) {
        points_m.emplace_back(T_map_lidar * point_m);
      }
    }
    map.ndt = ndt_from_points(points_m, map.ndt.frame, {}, 1);
    map.measurement.localizer.name = map.model.localizer.name = "searching";
    map.sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.0, 0.0, 2.0);
    const std::filesystem::path path = scratch_folder() / "street.slmap";
    EXPECT_TRUE(write_file_atomically(path, encode_map(map), IfExists::kReplace));
    std::vector<Pose> poses;
    for (int i = 0; i < 24; ++i) poses.push_back(pose_at(0.5 + 0.4 * i, -0.3, 0.02));
    street.map_file = path.string();
    street.test = drive_through(world, poses, 1.0);
    street.frame = map.ndt.frame;
    return street;
  }();
  return kStreet;
}

}  // namespace sightline
