#include "passes/build_surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compiler/base/random.h"
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

TEST(BuildSurface, CoversFlatGroundWithOneLevelDiscACell) {
  const Surface surface = must_build(draw_world("....\n....\n....\n").points);
  EXPECT_EQ(surface.discs.size(), 4U * 3U * 4U);  // square metres, four cells of 0.5 m each
  for (const SurfaceDisc& disc : surface.discs) {
    EXPECT_NEAR(disc.normal.z(), 1.0, 1e-9);
    EXPECT_NEAR(disc.centre_m.z(), 0.0, 1e-12);
    // Wide enough to leave no gap at the corners of its cell, too small for the next but one.
    EXPECT_GT(disc.radius_m, 0.5 / std::sqrt(2.0));
    EXPECT_LT(disc.radius_m, 0.5);
  }
}

TEST(BuildSurface, KeepsAPoleNarrow) {
  const Surface surface = must_build(draw_world("o").points);
  for (const SurfaceDisc& disc : surface.discs) {
    const bool is_above_ground = disc.centre_m.z() > 1.0;
    EXPECT_TRUE(!is_above_ground || disc.radius_m < 0.35);
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

TEST(BuildSurface, RefusesPointsThatMakeNoDisc) {
  PassContext ctx;
  const Result<Surface> surface = build_surface(ctx, {}, SurfacePoints{});
  ASSERT_FALSE(surface.has_value());
  EXPECT_EQ(surface.error().code, ErrorCode::kEmptyMap);
  EXPECT_EQ(surface.error().place, "pass build-surface");
}

}  // namespace
}  // namespace sightline
