#include "tests/bench/match_world.h"

#include <cstdio>
#include <fstream>
#include <optional>

#include "examples/town/drive/drive.h"
#include "tests/bench/pcl_peers.h"
#include "tests/bench/posed_set.h"

namespace sightline {
namespace {

std::vector<Pose> read_pose_rows(const std::string& path) {
  std::vector<Pose> poses;
  std::ifstream file(path);
  for (;;) {
    Pose pose = Pose::Identity();
    for (int i = 0; i < 12; ++i) file >> pose.matrix()(i / 4, i % 4);
    if (!file) return poses;
    pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    poses.push_back(pose);
  }
}

// Even scans make the map, odd ones are matched.
MatchWorld kitti_world(const std::string& folder, const std::vector<Pose>& poses) {
  MatchWorld world;
  world.name = "kitti_0005";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "/%010zu.pcd", i);
    const std::vector<Eigen::Vector3d> points_m = read_pcd_with_pcl(folder + name);
    if (i % 2 == 1) {
      world.scans.push_back(points_m);
      world.T_map_scan.push_back(poses[i]);
      continue;
    }
    for (const Eigen::Vector3d& point_m : points_m)
      world.map_points_m.push_back(poses[i] * point_m);
  }
  return world;
}

void add_drive(const town::Town& town, const town::DriveOptions& options, bool is_map,
               MatchWorld& world) {
  const Result<town::DriveSimulator> drive = town::DriveSimulator::make(town, options);
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    const town::TownScan scan = drive->scan(i);
    const Pose T_map_lidar = scan.T_town_vehicle * options.sensor.T_vehicle_lidar;
    std::vector<Eigen::Vector3d> points_m;
    for (const town::LabelledPoint& point : scan.points) {
      if (!is_map || !is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
    }
    if (!is_map) {
      world.scans.push_back(points_m);
      world.T_map_scan.push_back(T_map_lidar);
      continue;
    }
    for (const Eigen::Vector3d& point_m : points_m) {
      world.map_points_m.push_back(T_map_lidar * point_m);
    }
  }
}

MatchWorld town_world() {
  MatchWorld world;
  world.name = "generated town";
  world.leaf_m = 1.0;
  const town::Town town = *town::make_town({.seed = 3, .length_m = 200.0});
  town::DriveOptions mapping = town::usual_drive(town.options, 0, *town::town_sensor(16));
  add_drive(town, mapping, true, world);
  town::DriveOptions second = town::usual_drive(town.options, 1, *town::town_sensor(16));
  second.spacing_m = 3.0;
  add_drive(town, second, false, world);
  return world;
}

}  // namespace

MatchWorld make_match_world() {
  const std::optional<PosedSet> kitti = posed_kitti_0005();
  return kitti ? kitti_world(kitti->folder, read_pose_rows(kitti->pose_file)) : town_world();
}

}  // namespace sightline
