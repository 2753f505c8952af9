#include "formats/surroundings/surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

Surface two_patches() {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  surface.patches.push_back({{0, 0, 0}, {0.25, 0.2, 0.1}, {0.0, 0.6, 0.8}, 0.3});
  surface.patches.push_back(
      {{0, 1, 0}, {0.25, 0.7, 0.1}, {1.0, 0.0, 0.0}, 0.2, 0x8000000000000001});
  return surface;
}

TEST(Surface, LaysSidesLevelOnWallsAndAlongTheAxesOnGround) {
  SurfacePatch wall;
  wall.normal = Eigen::Vector3d(3.0, -4.0, 1.0).normalized();
  EXPECT_NEAR(side_of(wall).z(), 0.0, 1e-15);
  EXPECT_NEAR(side_of(wall).dot(wall.normal), 0.0, 1e-15);
  EXPECT_NEAR(side_of(wall).norm(), 1.0, 1e-15);
  SurfacePatch ground;
  EXPECT_NEAR(std::abs(side_of(ground).y()), 1.0, 1e-15);
}

TEST(Surface, VisitsTheMiddlesOfSolidSquaresAlone) {
  SurfacePatch patch{{0, 0, 0}, {1.0, 2.0, 3.0}, {0.0, 0.6, 0.8}, 0.4, 0x80f000000000a501};
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  for (const int parts : {1, 3}) {
    int count = 0;
    Eigen::Vector3d first_m = Eigen::Vector3d::Zero();
    visit_solid_squares(patch, parts, [&](const Eigen::Vector3d& middle_m) {
      const Eigen::Vector3d off_m = middle_m - patch.centre_m;
      EXPECT_NEAR(off_m.dot(patch.normal), 0.0, 1e-12);
      const int square = square_at(off_m.dot(along) / 0.4, off_m.dot(across) / 0.4);
      EXPECT_TRUE((patch.solid >> square & 1U) != 0) << square;
      if (count++ == 0) first_m = off_m;
    });
    EXPECT_EQ(count, 10 * parts * parts);
    EXPECT_NEAR(first_m.dot(along), -0.4 + 0.05 / parts, 1e-12);
  }
}

TEST(Surface, RefusesANormalThatIsNotOfUnitLength) {
  Surface surface = two_patches();
  surface.patches[1].normal *= 1.01;
  const Result<void> valid = validate(surface);
  ASSERT_FALSE(valid.has_value());
  EXPECT_EQ(valid.error().place, "patch 1");
}

TEST(Surface, RefusesAPatchOfNoWidth) {
  Surface surface = two_patches();
  surface.patches[0].half_side_m = 0.0;
  EXPECT_FALSE(validate(surface).has_value());
}

TEST(Surface, RefusesAPatchWithoutASolidSquare) {
  Surface surface = two_patches();
  surface.patches[1].solid = 0;
  EXPECT_FALSE(validate(surface).has_value());
}

TEST(Surface, CountsSquaresAlongTheSideThenAcross) {
  EXPECT_EQ(square_at(-1.0, -1.0), 0);
  EXPECT_EQ(square_at(1.0, -1.0), 7);
  EXPECT_EQ(square_at(-1.0, 1.0), 56);
  EXPECT_EQ(square_at(0.01, 0.26), 8 * 5 + 4);
}

TEST(Surface, RefusesPatchesOutOfOrder) {
  Surface surface = two_patches();
  std::swap(surface.patches[0], surface.patches[1]);
  EXPECT_FALSE(validate(surface).has_value());
}

}  // namespace
}  // namespace sightline
