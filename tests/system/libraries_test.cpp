#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "tests/system/exported_town.h"
#include "tests/system/program.h"

// A compiled town in the hands of OctoMap and of PCL's NDT.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(Libraries, OctomapReadsTheSpaceOfTheTown) {
  const fs::path folder = fresh_folder();
  export_to(folder / "town.bt", config_file(), "--format octomap --leaf 0.4");
  export_to(folder / "points.pcd", config_file(), "--format pcd --leaf 0.4");
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary((folder / "town.bt").string()));
  EXPECT_EQ(tree.getResolution(), 0.4);

  // One centroid in each voxel with points: those of the map.
  pcl::PointCloud<pcl::PointXYZ> points;
  ASSERT_EQ(pcl::io::loadPCDFile((folder / "points.pcd").string(), points), 0);
  octomap::KeySet surface = octomap::KeySet();
  for (const pcl::PointXYZ& p : points) surface.insert(tree.coordToKey(p.x, p.y, p.z));
  std::size_t occupied = 0;
  std::size_t off_surface = 0;
  std::size_t free = 0;
  for (octomap::OcTree::leaf_iterator leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    free += tree.isNodeOccupied(*leaf) ? 0 : 1;
    if (!tree.isNodeOccupied(*leaf) || leaf.getDepth() < tree.getTreeDepth()) continue;
    ++occupied;
    off_surface += surface.count(leaf.getKey()) == 0 ? 1 : 0;
  }
  EXPECT_GT(occupied, 30'000u);
  EXPECT_GT(free, 100'000u);
  EXPECT_EQ(off_surface, 0u);
}

TEST(Libraries, OctomapNeedsTheScansAndTheProgramSaysSo) {
  const fs::path file = fresh_folder() / "town.bt";
  const ProgramResult run =
      run_sightline("export " + map_file() + " --format octomap -o '" + file.string() + "'");
  EXPECT_EQ(run.status, 64);
  EXPECT_THAT(run.err, HasSubstr("SL1001 bad-argument"));
  EXPECT_THAT(run.err, HasSubstr("--format octomap needs the drive's scans, which no map carries"));
  EXPECT_FALSE(fs::exists(file));
}

// x y z and yaw of the first pose of drive 1, which is not the drive that made the map.
std::array<double, 4> first_pose() {
  std::ifstream poses(compiled_town() / "drive_1" / "poses.tum");
  std::string line;
  while (std::getline(poses, line) && line.starts_with('#')) {
  }
  std::istringstream fields(line);
  double time = 0.0, x = 0.0, y = 0.0, z = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 0.0;
  fields >> time >> x >> y >> z >> qx >> qy >> qz >> qw;
  return {x, y, z, 2.0 * std::atan2(qz, qw)};
}

TEST(Libraries, PclLocalizesAScanAtTheRangeOfTheMap) {
  const fs::path cloud = fresh_folder() / "points.pcd";
  export_to(cloud, config_file(), "--format pcd");
  const std::array<double, 4> pose = first_pose();
  std::ostringstream command;
  command.precision(12);
  command << SIGHTLINE_VEHICLE_PCL << " '" << map_file() << "' '" << cloud.string() << "' '"
          << (compiled_town() / "drive_1" / "scans" / "000000.pcd").string() << "' "
          << pose[0] + 0.3 << " " << pose[1] - 0.2 << " " << pose[2] << " "
          << pose[3] * 180.0 / std::numbers::pi + 1.0 << " 0.10 searching";
  const ProgramResult run = run_command(command.str());
  ASSERT_EQ(run.status, 0) << run.err;
  std::istringstream lines(run.out);
  std::string word;
  double range_m = 0.0, probability = 0.0;
  Eigen::Vector3d found_m;
  lines >> word >> range_m >> word >> probability >> word >> found_m.x() >> found_m.y() >>
      found_m.z();
  EXPECT_TRUE(range_m == 10.0 || range_m == 30.0) << run.out;
  EXPECT_LT((found_m - Eigen::Vector3d(pose[0], pose[1], pose[2])).norm(), 0.2) << run.out;
  EXPECT_THAT(run.out, HasSubstr("time_ms "));
}

}  // namespace
}  // namespace sightline
