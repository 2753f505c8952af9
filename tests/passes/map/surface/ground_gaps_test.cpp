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

const SurfacePatch* patch_at(const std::vector<SurfacePatch>& patches, double x_m, double y_m) {
  const auto found = std::ranges::find_if(patches, [&](const SurfacePatch& patch) {
    return (patch.centre_m.head<2>() - Eigen::Vector2d(x_m, y_m)).norm() < 1e-9;
  });
  return found == patches.end() ? nullptr : &*found;
}

TEST(GroundGaps, ClosesTheGapBetweenTwoPlacesAtTheirHeights) {
  const std::vector<SurfacePatch> between =
      ground_between(std::vector{level(0.5, 0.5, 1.0), level(7.5, 0.5, 1.35)}, 0.5);
  for (const double x_m : {1.5, 2.5, 3.5, 4.5, 5.5, 6.5}) {
    const SurfacePatch* patch = patch_at(between, x_m, 0.5);
    ASSERT_NE(patch, nullptr);
    EXPECT_NEAR(patch->centre_m.z(), 1.0 + 0.05 * (x_m - 0.5), 1e-12);
    EXPECT_EQ(patch->half_side_m, 0.5);
  }
}

TEST(GroundGaps, GoesOnLevelForFiveMetresWhereGroundEnds) {
  const std::vector<SurfacePatch> between = ground_between(std::vector{level(0.5, 0.5, 1.0)}, 0.5);
  EXPECT_EQ(between.size(), 8U * 5U);
  const SurfacePatch* patch = patch_at(between, 5.5, 0.5);
  ASSERT_NE(patch, nullptr);
  EXPECT_EQ(patch->centre_m.z(), 1.0);
  EXPECT_EQ(patch_at(between, 6.5, 0.5), nullptr);
}

TEST(GroundGaps, LeavesAStepOpenAndWhatIsTooFarApart) {
  const auto step = ground_between(std::vector{level(0.5, 0.5, 0.0), level(14.5, 0.5, 3.0)}, 0.5);
  EXPECT_EQ(patch_at(step, 7.5, 0.5), nullptr);
  const auto far = ground_between(std::vector{level(0.5, 0.5, 0.0), level(30.5, 0.5, 0.0)}, 0.5);
  EXPECT_EQ(patch_at(far, 15.5, 0.5), nullptr);
}

TEST(GroundGaps, AddsNothingWhereGroundWasSeenNorFromWalls) {
  std::vector<SurfacePatch> street;
  for (int x = 0; x < 10; ++x) street.push_back(level(x + 0.5, 0.5, 0.0));
  const std::vector<SurfacePatch> beside = ground_between(street, 0.5);
  for (int x = 0; x < 10; ++x) EXPECT_EQ(patch_at(beside, x + 0.5, 0.5), nullptr);
  for (SurfacePatch& patch : street) patch.normal = Eigen::Vector3d::UnitX();
  EXPECT_TRUE(ground_between(street, 0.5).empty());
}

TEST(GroundGaps, TakesTheNearestPairOfEnds) {
  const std::vector<SurfacePatch> between =
      ground_between(std::vector{level(0.5, 2.5, 0.0), level(6.5, 2.5, 0.0), level(3.5, 0.5, 0.1),
                                 level(3.5, 4.5, 0.1)},
                     0.5);
  const SurfacePatch* middle = patch_at(between, 3.5, 2.5);
  ASSERT_NE(middle, nullptr);
  EXPECT_NEAR(middle->centre_m.z(), 0.1, 1e-12);
}

}  // namespace
}  // namespace sightline
