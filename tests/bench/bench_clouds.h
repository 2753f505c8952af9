#pragma once

#include <Eigen/Core>
#include <vector>

namespace sightline {

// What benchmarks of maps work on: the set kitti_0005 of tests/README.md where it is there and
// SIGHTLINE_KITTI_POSES names its poses (12 numbers a row), else a drawn street of the same size.
struct BenchClouds {
  const char* name = "";
  std::vector<Eigen::Vector3d> map_points_m;  // even scans in the map frame, as they were recorded
  std::vector<Eigen::Vector3d> scan_points_m;
};
const BenchClouds& bench_clouds();

BenchClouds street_clouds();
std::vector<Eigen::Vector3d> street_scan_points();

std::vector<Eigen::Vector3d> shuffled(std::vector<Eigen::Vector3d> points_m);

// Streets of a city of 2 x 2 km: few points to a voxel, and no more voxels in their box than 32
// bits count (pcl::VoxelGrid needs that).
std::vector<Eigen::Vector3d> sparse_city_points();

}  // namespace sightline
