#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <sstream>

#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// x y z and yaw of the first pose of a drive: "mapping", or "drive_1", which did not make the map.
std::array<double, 4> first_pose(const std::string& drive) {
  std::ifstream poses(compiled_town() / drive / "poses.tum");
  std::string line;
  while (std::getline(poses, line) && line.starts_with('#')) {
  }
  std::istringstream fields(line);
  double time = 0.0, x = 0.0, y = 0.0, z = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 0.0;
  fields >> time >> x >> y >> z >> qx >> qy >> qz >> qw;
  return {x, y, z, 2.0 * std::atan2(qz, qw)};
}

std::vector<Eigen::Vector3d> points_of(const fs::path& file) {
  pcl::PCLPointCloud2 cloud;
  EXPECT_EQ(pcl::io::loadPLYFile(file.string(), cloud), 0);
  std::vector<Eigen::Vector3d> points_m(static_cast<std::size_t>(cloud.width) * cloud.height);
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::memcpy(&points_m[i][static_cast<Eigen::Index>(axis)],
                  &cloud.data[i * cloud.point_step + cloud.fields[axis].offset], sizeof(double));
    }
  }
  return points_m;
}

// The town lies farther from the origin than an octree reaches, so this one is in map coordinates:
// the corner of a tile of 64 m at or below the first scan.
TEST(Libraries, OctomapReadsTheSpaceOfTheTown) {
  const fs::path folder = fresh_folder();
  const ProgramResult run =
      run_successfully("export " + config_file() + " -q -o '" + (folder / "town.bt").string() +
                       "' --format octomap --leaf 0.4");
  EXPECT_THAT(run.err, HasSubstr("the octree is in map coordinates"));
  export_to(folder / "points.ply", config_file(), "--format ply --leaf 0.4");
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary((folder / "town.bt").string()));
  EXPECT_EQ(tree.getResolution(), 0.4);

  // One centroid in each voxel with points: those of the map.
  const std::vector<Eigen::Vector3d> points_m = points_of(folder / "points.ply");
  const auto tile_below = [](double x_m) { return 64.0 * std::floor(x_m / 64.0); };
  const std::array<double, 4> first = first_pose("mapping");
  const Eigen::Vector3d origin_m(tile_below(first[0]) - 4e5, tile_below(first[1]) - 5.4e6,
                                 tile_below(first[2]));
  octomap::KeySet surface = octomap::KeySet();
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Vector3d p_m = point_m - origin_m;
    surface.insert(tree.coordToKey(p_m.x(), p_m.y(), p_m.z()));
  }
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
  EXPECT_THAT(
      run.err,
      HasSubstr("--format octomap needs the scans of the drive, which maps do not contain"));
  EXPECT_FALSE(fs::exists(file));
}

TEST(Libraries, PclLocalizesAScanAtTheRangeOfTheMap) {
  const fs::path cloud = fresh_folder() / "town_map";
  export_to(cloud, config_file(), "--format autoware --world utm:32N");
  const std::array<double, 4> pose = first_pose("drive_1");
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
