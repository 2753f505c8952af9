#include "passes/matching/scan_preparation.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

TEST(SortIntoShells, PutsEveryCropInAPrefixAndKeepsTheOrder) {
  const std::vector<Eigen::Vector3d> points_m = {
      {0.0, 30.0, 0.0}, {5.0, 0.0, 0.0}, {0.0, 0.0, 10.0}, {12.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
  const std::vector<double> ranges_m = {10.0, 20.0};
  const ShelledScan scan = sort_into_shells(points_m, ranges_m);
  EXPECT_EQ(scan.counts, (std::vector<std::size_t>{3, 4}));
  ASSERT_EQ(scan.points_m.size(), 4u);
  EXPECT_EQ(scan.points_m[0], points_m[1]);
  EXPECT_EQ(scan.points_m[1], points_m[2]) << "a point at the very range belongs to its crop";
  EXPECT_EQ(scan.points_m[2], points_m[4]);
  EXPECT_EQ(scan.points_m[3], points_m[3]);
}

TEST(SortIntoShells, KeepsThePointsThatAFilterWouldKeep) {
  Random random(9);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 3000; ++i) points_m.push_back(random_vector(random, -40.0, 40.0));
  const std::vector<double> ranges_m = {10.0, 15.0, 20.0, 50.0};
  const ShelledScan scan = sort_into_shells(points_m, ranges_m);
  for (std::size_t range = 0; range < ranges_m.size(); ++range) {
    std::size_t expected = 0;
    for (const Eigen::Vector3d& point_m : points_m) {
      if (point_m.squaredNorm() <= ranges_m[range] * ranges_m[range]) ++expected;
    }
    EXPECT_EQ(scan.crop(range).size(), expected);
    for (const Eigen::Vector3d& point_m : scan.crop(range)) {
      EXPECT_LE(point_m.norm(), ranges_m[range]);
    }
  }
}

TEST(VoxelSubsample, AveragesEachVoxelAndSortsByKey) {
  const std::vector<Eigen::Vector3d> points_m = {
      {1.5, 0.5, 0.5}, {0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}, {-0.5, 3.0, 0.0}, {0.5, 0.5, -0.1}};
  const std::vector<Eigen::Vector3d> expected_m = {
      {-0.5, 3.0, 0.0}, {0.5, 0.5, -0.1}, {0.5, 0.5, 0.25}, {1.5, 0.5, 0.5}};
  EXPECT_EQ(voxel_subsample(points_m, 1.0), expected_m);
}

TEST(VoxelSubsample, AgreesWithAnOrderedMapOfVoxels) {
  Random random(4);
  for (const double leaf_m : {0.1, 0.5, 1.0, 3.0}) {
    std::vector<Eigen::Vector3d> points_m;
    for (int i = 0; i < 4000; ++i) points_m.push_back(random_vector(random, -20.0, 20.0));
    std::map<CellKey, std::pair<Eigen::Vector3d, int>> voxels;
    for (const Eigen::Vector3d& point_m : points_m) {
      auto& [sum_m, count] =
          voxels.try_emplace(cell_key(point_m, leaf_m), Eigen::Vector3d::Zero(), 0).first->second;
      sum_m += point_m;
      ++count;
    }
    std::vector<Eigen::Vector3d> expected_m;
    for (const auto& [key, voxel] : voxels) expected_m.push_back(voxel.first / voxel.second);
    EXPECT_EQ(voxel_subsample(points_m, leaf_m), expected_m);
  }
}

TEST(VoxelSubsample, OfNothingIsNothing) { EXPECT_TRUE(voxel_subsample({}, 1.0).empty()); }

}  // namespace
}  // namespace sightline
