#include "passes/matching/scan_preparation.h"

#include <gtest/gtest.h>
#include <cmath>
#include <map>

#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

// Means of voxels, each summed in the order of points.
std::vector<Eigen::Vector3d> expected_centroids(const std::vector<Eigen::Vector3d>& points_m,
                                                double leaf_m) {
  std::map<CellKey, std::pair<Eigen::Vector3d, double>> voxels;
  for (const Eigen::Vector3d& point_m : points_m) {
    auto& [sum_m, count] =
        voxels.try_emplace(cell_key(point_m, leaf_m), Eigen::Vector3d::Zero(), 0.0).first->second;
    sum_m += point_m;
    count += 1.0;
  }
  std::vector<Eigen::Vector3d> centroids_m;
  for (const auto& [key, voxel] : voxels) centroids_m.push_back(voxel.first / voxel.second);
  return centroids_m;
}

TEST(Crop, KeepsPointsUpToTheRangeInTheirOrder) {
  const std::vector<Eigen::Vector3d> points_m = {
      {0.0, 30.0, 0.0}, {5.0, 0.0, 0.0}, {0.0, 0.0, 10.0}, {12.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
  const std::vector<Eigen::Vector3d> expected_m = {
      {5.0, 0.0, 0.0}, {0.0, 0.0, 10.0}, {1.0, 1.0, 0.0}};
  EXPECT_EQ(crop(points_m, 10.0), expected_m) << "a point at the very range belongs to the crop";
  EXPECT_TRUE(crop(points_m, 1.0).empty());
  EXPECT_TRUE(crop({}, 1.0).empty());
}

TEST(Crop, OfALongerRangeHoldsThatOfAShorterOne) {
  Random random(9);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 3000; ++i) points_m.push_back(random_vector(random, -40.0, 40.0));
  for (double range_m = 5.0; range_m < 70.0; range_m += 5.0) {
    EXPECT_EQ(crop(crop(points_m, range_m + 5.0), range_m), crop(points_m, range_m));
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
    EXPECT_EQ(voxel_subsample(points_m, leaf_m), expected_centroids(points_m, leaf_m));
  }
}

TEST(VoxelSubsample, AssignsPointsOnFacesAsTheQuotientSays) {
  // 0.3 / 0.1 is below 3 in double and 0.3 * (1 / 0.1) is not, or the other way round elsewhere.
  for (const double leaf_m : {0.1, 0.3, 0.7, 1.0}) {
    for (int i = -50; i <= 50; ++i) {
      const Eigen::Vector3d point_m(leaf_m * i, 0.1 * i, 0.3 * i);
      const std::vector<Eigen::Vector3d> two_m = {point_m,
                                                  (leaf_m * 0.5) * Eigen::Vector3d::Ones()};
      const bool is_same = cell_key(two_m[0], leaf_m) == cell_key(two_m[1], leaf_m);
      EXPECT_EQ(voxel_subsample(two_m, leaf_m).size(), is_same ? 1u : 2u);
      const std::vector<Eigen::Vector3d> near_m = {
          point_m, leaf_m * Eigen::Vector3d(std::floor(point_m.x() / leaf_m) + 0.5,
                                            std::floor(point_m.y() / leaf_m) + 0.5,
                                            std::floor(point_m.z() / leaf_m) + 0.5)};
      EXPECT_EQ(voxel_subsample(near_m, leaf_m).size(), 1u);
    }
  }
}

TEST(VoxelSubsample, OrdersVoxelsFartherApartThanOneNumberHolds) {
  const std::vector<Eigen::Vector3d> points_m = {
      {1e9, -1e9, 1e9}, {-1e9, 1e9, -1e9}, {-1e9, -1e9, 5.0}, {-1e9, -1e9, -5.0}};
  const std::vector<Eigen::Vector3d> expected_m = {points_m[3], points_m[2], points_m[1],
                                                   points_m[0]};
  EXPECT_EQ(voxel_subsample(points_m, 1.0), expected_m);
}

TEST(VoxelSubsample, GivesTheSameBytesWhetherItSortsOrLooksUp) {
  // More points than are sorted without a look: first of voxels with many, then with one each.
  constexpr int kCount = 300000;
  for (const double reach_m : {20.0, 2000.0}) {
    Random random(5);
    std::vector<Eigen::Vector3d> points_m;
    for (int i = 0; i < kCount; ++i) {
      points_m.emplace_back(random.uniform(-reach_m, reach_m), random.uniform(-reach_m, reach_m),
                            random.uniform(-1.0, 1.0));
    }
    EXPECT_EQ(voxel_subsample(points_m, 1.0), expected_centroids(points_m, 1.0)) << reach_m;
  }
}

TEST(VoxelSubsample, SortsKeysOfMoreThan32Bits) {
  Random random(6);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 5000; ++i) points_m.push_back(random_vector(random, -3e5, 3e5));
  for (int i = 0; i < 5000; ++i) points_m.push_back(random_vector(random, -5.0, 5.0));
  EXPECT_EQ(voxel_subsample(points_m, 0.5), expected_centroids(points_m, 0.5));
}

TEST(VoxelSubsample, OfNothingIsNothing) { EXPECT_TRUE(voxel_subsample({}, 1.0).empty()); }

}  // namespace
}  // namespace sightline
