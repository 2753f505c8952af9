#include "passes/map/build_surface.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "formats/base/random.h"
#include "tests/support/test_context.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

Surface must_build(const SurfacePoints& points, const BuildSurfaceOptions& options = {},
                   int threads = 1) {
  return value_of(whole_rows(build_surface(TestContext(threads), options, points)));
}

TEST(BuildSurface, CoversFlatGroundWithOneLevelPatchACell) {
  const Surface surface = must_build(draw_world("....\n....\n....\n").points);
  int count = 0;
  for (const SurfacePatch& patch : surface.patches) {
    const Eigen::Vector3d& at_m = patch.centre_m;
    if (at_m.x() < 0.0 || at_m.y() < 0.0 || at_m.x() > 4.0 || at_m.y() > 3.0) continue;
    ++count;
    EXPECT_NEAR(patch.normal.z(), 1.0, 1e-9);
    EXPECT_NEAR(patch.centre_m.z(), 0.0, 1e-12);
    // Wide enough to leave no gap at the edges of its cell, too small for the next but one.
    EXPECT_GT(patch.half_side_m, 0.25);
    EXPECT_LT(patch.half_side_m, 0.5);
  }
  EXPECT_EQ(count, 4 * 3 * 4);  // square metres, four cells of 0.5 m each
}

bool is_solid_at(const Surface& surface, const Eigen::Vector3d& place_m) {
  return std::ranges::any_of(surface.patches, [&](const SurfacePatch& patch) {
    const Eigen::Vector3d off_m = (place_m - patch.centre_m) / patch.half_side_m;
    const Eigen::Vector3d side = side_of(patch);
    const double along = off_m.dot(side);
    const double across = off_m.dot(patch.normal.cross(side));
    if (std::abs(along) > 1.0 || std::abs(across) > 1.0) return false;
    if (std::abs(off_m.dot(patch.normal)) * patch.half_side_m > 1e-3) return false;
    return (patch.solid >> square_at(along, across) & 1) != 0;
  });
}

// A wall 10 m ahead of a sensor at the origin, 8 m wide and 4 m high, of returns 5 cm apart. Where
// `is_open` says so the rays go on to another wall, 20 m off.
SurfacePoints seen_wall(const std::function<bool(double, double)>& is_open) {
  Scan scan;
  for (double y = -3.98; y < 4.0; y += 0.05) {
    for (double z = -1.98; z < 2.0; z += 0.05) {
      scan.points_m.emplace_back((is_open(y, z) ? 2.0 : 1.0) * Eigen::Vector3d(10.1, y, z));
    }
  }
  SurfacePoints points;
  points.scans = {{0, Pose::Identity(), 0.5, 100.0}};
  points.store = memory_scan_store({scan});
  return points;
}

TEST(BuildSurface, IsOpenWhereRaysWentThroughAndSolidAroundThat) {
  const auto is_open = [](double y, double z) {
    return std::abs(y) < 0.2 && std::abs(z - 0.3) < 0.2;
  };
  const Surface surface = must_build(seen_wall(is_open));
  EXPECT_FALSE(is_solid_at(surface, {10.1, 0.0, 0.3}));
  EXPECT_TRUE(is_solid_at(surface, {20.2, 0.0, 0.6}));
  for (const double aside_m : {-0.35, 0.35}) {
    EXPECT_TRUE(is_solid_at(surface, {10.1, aside_m, 0.3}));
    EXPECT_TRUE(is_solid_at(surface, {10.1, 0.0, 0.3 + aside_m}));
  }
}

TEST(BuildSurface, ReachesNoFartherThanItsReturns) {
  const Surface surface = must_build(seen_wall([](double, double) { return false; }));
  EXPECT_TRUE(is_solid_at(surface, {10.1, 3.95, 1.0}));
  EXPECT_TRUE(is_solid_at(surface, {10.1, 1.0, 1.95}));
  EXPECT_FALSE(is_solid_at(surface, {10.1, 4.15, 1.0}));
  EXPECT_FALSE(is_solid_at(surface, {10.1, 1.0, 2.15}));
}

TEST(BuildSurface, ClosesAGapBetweenTwoScanLinesOfOneWall) {
  // Nothing was seen between heights of -0.6 and 0.6 m, by any ray.
  SurfacePoints points;
  for (double y = -3.98; y < 4.0; y += 0.05) {
    for (double z = 0.6; z < 2.0; z += 0.1) {
      points.points_m.emplace_back(10.1, y, z);
      points.points_m.emplace_back(10.1, y, -z);
    }
  }
  const Surface surface = must_build(points);
  for (double y = -3.5; y < 3.5; y += 0.1) {
    EXPECT_TRUE(is_solid_at(surface, {10.1, y, 0.05})) << "at " << y;
  }
}

TEST(BuildSurface, KeepsAPoleNarrow) {
  const Surface surface = must_build(draw_world("o").points);
  for (const SurfacePatch& patch : surface.patches) {
    if (patch.centre_m.z() < 1.0) continue;
    // At most four of eight squares of 0.09 m wide.
    std::uint64_t columns = 0;
    for (int row = 0; row < kPatchSquares; ++row) columns |= patch.solid >> 8 * row & 0xff;
    EXPECT_LE(std::popcount(columns), 4);
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
  const Error refused = failure_of(whole_rows(build_surface(TestContext(), {}, SurfacePoints{})));
  EXPECT_EQ(refused.code, ErrorCode::kEmptyMap);
  EXPECT_EQ(refused.place, "pass build-surface");
}

}  // namespace
}  // namespace sightline
