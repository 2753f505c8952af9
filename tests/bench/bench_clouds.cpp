#include "tests/bench/bench_clouds.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>

#include "formats/base/random.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/bench/posed_set.h"

namespace sightline {
namespace {

std::vector<Eigen::Isometry3d> read_pose_rows(const std::string& path) {
  std::vector<Eigen::Isometry3d> poses;
  std::ifstream file(path);
  for (;;) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) file >> pose.matrix()(i / 4, i % 4);
    if (!file) return poses;
    poses.push_back(pose);
  }
}

std::vector<Eigen::Vector3d> read_scan(const std::string& folder, std::size_t index) {
  char name[32];
  std::snprintf(name, sizeof name, "/%010zu.pcd", index);
  Result<PointCloudFile> cloud = read_point_cloud(folder + name);
  return cloud ? std::move(cloud->points_m) : std::vector<Eigen::Vector3d>();
}

BenchClouds kitti_clouds(const std::string& folder, const std::string& pose_file) {
  const std::vector<Eigen::Isometry3d> poses = read_pose_rows(pose_file);
  BenchClouds clouds;
  clouds.name = "kitti_0005";
  clouds.scan_points_m = read_scan(folder, 1);
  for (std::size_t i = 0; i < poses.size(); i += 2) {
    for (const Eigen::Vector3d& point_m : read_scan(folder, i)) {
      clouds.map_points_m.push_back(poses[i] * point_m);
    }
  }
  return clouds;
}

// Where a ray from (0, 0, 1.73) meets the ground, walls 8.6 m to each side or a gable 60 m ahead.
Eigen::Vector3d street_return(double azimuth_rad, double elevation_rad) {
  const Eigen::Vector3d ray(std::cos(elevation_rad) * std::cos(azimuth_rad),
                            std::cos(elevation_rad) * std::sin(azimuth_rad),
                            std::sin(elevation_rad));
  double distance_m = 60.0 / std::abs(ray.x());
  distance_m = std::min(distance_m, 8.6 / std::abs(ray.y()));
  if (ray.z() < 0.0) distance_m = std::min(distance_m, 1.73 / -ray.z());
  return distance_m * ray;
}

// Beam after beam, each once round, as KITTI's scans are.
std::vector<Eigen::Vector3d> street_scan(std::uint64_t seed) {
  constexpr int kBeams = 64;
  constexpr int kSteps = 1900;
  Random random(seed);
  std::vector<Eigen::Vector3d> points_m;
  for (int beam = 0; beam < kBeams; ++beam) {
    for (int step = 0; step < kSteps; ++step) {
      const double azimuth_rad = 2.0 * std::numbers::pi * (step + 0.5) / kSteps;
      const double elevation_rad = (2.0 - 26.8 * beam / (kBeams - 1)) * std::numbers::pi / 180.0;
      const Eigen::Vector3d point_m = street_return(azimuth_rad, elevation_rad);
      points_m.push_back((1.0 + 0.02 * random.normal() / point_m.norm()) * point_m);
    }
  }
  return points_m;
}

}  // namespace

std::vector<Eigen::Vector3d> street_scan_points() { return street_scan(1000); }

BenchClouds street_clouds() {
  BenchClouds clouds;
  clouds.name = "drawn street";
  clouds.scan_points_m = street_scan_points();
  for (std::uint64_t scan = 0; scan < 77; ++scan) {
    // Neither ground nor walls at the face of a cell.
    const Eigen::Vector3d place_m(0.9 * static_cast<double>(scan), 0.0, 2.1);
    for (const Eigen::Vector3d& point_m : street_scan(scan)) {
      clouds.map_points_m.push_back(place_m + point_m);
    }
  }
  return clouds;
}

const BenchClouds& bench_clouds() {
  static const BenchClouds kClouds = [] {
    const std::optional<PosedSet> kitti = posed_kitti_0005();
    return kitti ? kitti_clouds(kitti->folder, kitti->pose_file) : street_clouds();
  }();
  return kClouds;
}

std::vector<Eigen::Vector3d> shuffled(std::vector<Eigen::Vector3d> points_m) {
  Random random(5);
  for (std::size_t i = points_m.size(); i > 1; --i) {
    std::swap(points_m[i - 1], points_m[random.below(i)]);
  }
  return points_m;
}

std::vector<Eigen::Vector3d> sparse_city_points() {
  constexpr int kStreets = 20;
  constexpr int kPerStreet = 100000;
  constexpr double kLength_m = 2000.0;
  Random random(3);
  std::vector<Eigen::Vector3d> points_m;
  for (int street = 0; street < kStreets; ++street) {
    const double across_m = kLength_m / kStreets * street;
    for (int i = 0; i < kPerStreet; ++i) {
      // Driven from one end to the other, seeing 60 m around.
      const double along_m = kLength_m * i / kPerStreet + random.uniform(-60.0, 60.0);
      const double aside_m = across_m + random.uniform(-15.0, 15.0);
      const double up_m = random.uniform(0.0, 12.0);
      if (street % 2 == 0) points_m.emplace_back(along_m, aside_m, up_m);
      if (street % 2 != 0) points_m.emplace_back(aside_m, along_m, up_m);
    }
  }
  return points_m;
}

}  // namespace sightline
