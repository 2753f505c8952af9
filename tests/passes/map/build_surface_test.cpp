#include "passes/map/build_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/random.h"
#include "tests/support/toy_world.h"

namespace sightline {
namespace {

Surface must_build(const SurfacePoints& points, const BuildSurfaceOptions& options = {},
                   int threads = 1) {
  PassContext ctx;
  ctx.threads = threads;
  const Result<Surface> surface = build_surface(ctx, options, points);
  EXPECT_TRUE(surface.has_value());
  return surface.has_value() ? *surface : Surface{};
}

TEST(BuildSurface, CoversFlatGroundWithOneLevelPatchACell) {
  const Surface surface = must_build(draw_world("....\n....\n....\n").points);
  EXPECT_EQ(surface.patches.size(), 4U * 3U * 4U);  // square metres, four cells of 0.5 m each
  for (const SurfacePatch& patch : surface.patches) {
    EXPECT_NEAR(patch.normal.z(), 1.0, 1e-9);
    EXPECT_NEAR(patch.centre_m.z(), 0.0, 1e-12);
    // Wide enough to leave no gap at the edges of its cell, too small for the next but one.
    EXPECT_GT(patch.half_side_m, 0.25);
    EXPECT_LT(patch.half_side_m, 0.5);
  }
}

TEST(BuildSurface, KeepsAPoleNarrow) {
  const Surface surface = must_build(draw_world("o").points);
  for (const SurfacePatch& patch : surface.patches) {
    const bool is_above_ground = patch.centre_m.z() > 1.0;
    EXPECT_TRUE(!is_above_ground || patch.half_side_m < 0.31);
  }
}

TEST(BuildSurface, IsValidAndTheSameForAnyNumberOfThreads) {
  Random random(1);
  SurfacePoints points;
  for (int i = 0; i < 100000; ++i) {
    points.points_m.emplace_back(random.uniform(-70.0, 70.0), random.uniform(-70.0, 70.0),
                                 random.uniform(0.0, 0.5));
  }
  const Surface surface = must_build(points);
  EXPECT_TRUE(validate(surface).has_value());
  EXPECT_EQ(to_bytes(surface), to_bytes(must_build(points, {}, 3)));
}

TEST(BuildSurface, RefusesPointsThatMakeNoPatch) {
  PassContext ctx;
  const Result<Surface> surface = build_surface(ctx, {}, SurfacePoints{});
  ASSERT_FALSE(surface.has_value());
  EXPECT_EQ(surface.error().code, ErrorCode::kEmptyMap);
  EXPECT_EQ(surface.error().place, "pass build-surface");
}

}  // namespace
}  // namespace sightline
