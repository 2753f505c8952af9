#include "passes/map/surface/ground_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sightline {
namespace {

SurfacePatch level(double x_m, double y_m, double z_m) {
  SurfacePatch patch;
  patch.centre_m = {x_m, y_m, z_m};
  patch.half_side_m = 0.36;
  return patch;
}

TEST(GroundGaps, ClosesTheGapBetweenTwoPlacesAtTheirHeights) {
  const std::vector<SurfacePatch> between =
      ground_between(std::vector{level(0.5, 0.5, 1.0), level(4.5, 0.5, 1.2)}, 0.5);
  ASSERT_EQ(between.size(), 3U);
  for (const SurfacePatch& patch : between) {
    EXPECT_NEAR(patch.centre_m.z(), 1.0 + 0.05 * (patch.centre_m.x() - 0.5), 1e-12);
    EXPECT_NEAR(patch.centre_m.y(), 0.5, 1e-12);
    EXPECT_EQ(patch.half_side_m, 0.5);
  }
}

TEST(GroundGaps, LeavesAStepOpenAndWhatIsTooFarApart) {
  EXPECT_TRUE(ground_between(std::vector{level(0.5, 0.5, 0.0), level(4.5, 0.5, 1.5)}, 0.5).empty());
  EXPECT_TRUE(
      ground_between(std::vector{level(0.5, 0.5, 0.0), level(20.5, 0.5, 0.0)}, 0.5).empty());
}

TEST(GroundGaps, AddsNothingWhereGroundWasSeenNorFromWalls) {
  std::vector<SurfacePatch> street;
  for (int x = 0; x < 10; ++x) street.push_back(level(x + 0.5, 0.5, 0.0));
  EXPECT_TRUE(ground_between(street, 0.5).empty());
  std::vector<SurfacePatch> walls = {level(0.5, 0.5, 0.0), level(4.5, 0.5, 0.0)};
  for (SurfacePatch& wall : walls) wall.normal = Eigen::Vector3d::UnitX();
  EXPECT_TRUE(ground_between(walls, 0.5).empty());
}

TEST(GroundGaps, TakesTheNearestPairOfEnds) {
  const std::vector<SurfacePatch> between =
      ground_between(std::vector{level(0.5, 2.5, 0.0), level(6.5, 2.5, 0.0), level(3.5, 0.5, 0.1),
                                 level(3.5, 4.5, 0.1)},
                     0.5);
  const auto middle = std::ranges::find_if(between, [](const SurfacePatch& patch) {
    return (patch.centre_m.head<2>() - Eigen::Vector2d(3.5, 2.5)).norm() < 1e-9;
  });
  ASSERT_NE(middle, between.end());
  EXPECT_NEAR(middle->centre_m.z(), 0.1, 1e-12);
}

}  // namespace
}  // namespace sightline
