#include "passes/map/build_nd_surface.h"

#include <gtest/gtest.h>
#include <bit>
#include <cmath>
#include <string>

#include "passes/map/places/ground_floors.h"
#include "tests/support/test_context.h"
#include "tests/support/test_files.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

NdtMap level_street() {
  NdtMap map;
  for (std::int32_t x = 0; x < 10; ++x) {
    for (std::int32_t y = 0; y < 3; ++y) {
      Nd nd;
      nd.key = {x, y, 0};
      nd.point_count = 100;
      nd.mean_m = {2.0 * x + 1.0, 2.0 * y + 1.0, 0.3};
      nd.covariance_m2 = Eigen::Vector3d(4.0 / 12.0, 4.0 / 12.0, 1e-4).asDiagonal();
      decompose(nd);
      map.nds.push_back(nd);
    }
  }
  return map;
}

TEST(BuildNdSurface, IsAPatchForEachNdAndSaysThatItIsRougher) {
  TestContext ctx;
  const Surface surface = value_of(whole_rows(build_nd_surface(ctx, {}, level_street())));
  EXPECT_TRUE(validate(surface).has_value());
  EXPECT_EQ(surface.patches.size(), 30U);
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_NE(ctx.warnings[0].find("contains no surface"), std::string::npos);
}

TEST(BuildNdSurface, HasGroundThatAVehicleStandsOn) {
  const Surface surface = value_of(whole_rows(build_nd_surface(TestContext(), {}, level_street())));
  const GroundFloors floors(surface);
  for (double x_m = 0.1; x_m < 20.0; x_m += 0.7) {
    ASSERT_EQ(floors.at({x_m, 3.0}).size(), 1U) << x_m;
    EXPECT_NEAR(floors.at({x_m, 3.0}).front(), 0.3, 1e-12);
  }
  EXPECT_TRUE(floors.at({10.0, 8.0}).empty());
}

TEST(BuildNdSurface, ReturnsThatTheDiskIsFull) {
  const NdtMap few = level_street();
  NdtMap map;
  for (std::int32_t x = 0; x < 250000; ++x) {
    map.nds.push_back(few.nds.front());
    map.nds.back().key.x = x;
    map.nds.back().mean_m.x() = 2.0 * x + 1.0;
  }
  const NoLargeFiles full_disk;
  EXPECT_EQ(failure_of(build_nd_surface(TestContext(), {}, map)).code, ErrorCode::kDiskFull);
}

TEST(BuildNdSurface, RefusesAMapWithoutNds) {
  EXPECT_EQ(failure_of(whole_rows(build_nd_surface(TestContext(), {}, NdtMap{}))).code,
            ErrorCode::kEmptyMap);
}

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
  EXPECT_EQ(std::popcount(surface_of_nds(one_nd({0.3, 0.29, 0.28})).patches[0].solid), 32);
}

}  // namespace
}  // namespace sightline
