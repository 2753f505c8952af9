#include "passes/map/surface/nd_surface.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

namespace sightline {
namespace {

NdtMap one_nd(const Eigen::Vector3d& variance_m2) {
  NdtMap map;
  Nd nd;
  nd.point_count = 100;
  nd.mean_m = {1.0, 1.0, 1.0};
  nd.key = cell_key(nd.mean_m, map.cell_m);
  nd.covariance_m2 = variance_m2.asDiagonal();
  decompose(nd);
  map.nds.push_back(nd);
  return map;
}

TEST(NdSurface, OfAWallReachesAsFarAsEvenPointsOfItsVariance) {
  // Points evenly over 2 m x 2 m have a variance of 4 / 12.
  const Surface wall = surface_of_nds(one_nd({4.0 / 12.0, 1e-4, 4.0 / 12.0}));
  ASSERT_EQ(wall.patches.size(), 1U);
  EXPECT_TRUE(validate(wall).has_value());
  EXPECT_NEAR(wall.patches[0].half_side_m, 1.0, 1e-12);
  EXPECT_NEAR(std::abs(wall.patches[0].normal.y()), 1.0, 1e-12);
  EXPECT_EQ(std::popcount(wall.patches[0].solid), 64);
}

TEST(NdSurface, OfAPoleIsNarrowAndOfLeavesHalfOpen) {
  const Surface pole = surface_of_nds(one_nd({0.0025, 0.0024, 4.0 / 12.0}));
  EXPECT_EQ(std::popcount(pole.patches[0].solid), 16);  // two columns of eight
  const Surface leaves = surface_of_nds(one_nd({0.3, 0.29, 0.28}));
  EXPECT_EQ(std::popcount(leaves.patches[0].solid), 32);
}

}  // namespace
}  // namespace sightline
