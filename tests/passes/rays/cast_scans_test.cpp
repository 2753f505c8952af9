#include "passes/rays/cast_scans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "passes/map/build_surface.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_surface.h"

namespace sightline {
namespace {

const char* const kStreet = R"(
##############################
..............................
....@...@...@...@...o....@....
..............................
##############################
)";

SensorProfile five_beams() {
  SensorProfile sensor;
  sensor.beam_elevations_deg = {-15.0, -10.0, 0.0, 5.0, 10.0};
  sensor.azimuth_step_deg = 1.0;
  return sensor;
}

Surface surface_of(const ToyWorld& world) {
  PassContext ctx;
  const Result<Surface> surface = whole(build_surface(ctx, {}, world.points));
  EXPECT_TRUE(surface.has_value());
  return *surface;
}

VirtualScans must_cast(const Surface& surface, const Sites& sites, const SensorProfile& sensor,
                       int threads = 1, const CastScansOptions& options = {}) {
  PassContext ctx;
  ctx.threads = threads;
  const Result<VirtualScans> scans = cast_scans(ctx, options, surface, sites, sensor);
  EXPECT_TRUE(scans.has_value());
  EXPECT_TRUE(validate(*scans).has_value());
  return *scans;
}

TEST(CastScans, FindsOneBeamsHitsOnAWallAndTheGroundByHand) {
  const ToyWorld world = draw_world(kStreet);
  SensorProfile one = five_beams();
  one.beam_elevations_deg = {0.0};
  one.azimuth_step_deg = 90.0;
  Sites third;
  third.sites = {world.sites.sites[2]};
  const VirtualScans scans = must_cast(surface_of(world), third, one);
  // Ahead: the pole, 8 m on. Left and right: the walls. Behind: nothing.
  ASSERT_EQ(scans.points_m.size(), 3U);
  EXPECT_TRUE(std::any_of(scans.points_m.begin(), scans.points_m.end(), [](const auto& point_m) {
    return std::abs(point_m.y() - 1.5) < 0.02 && std::abs(point_m.x()) < 1e-9;
  }));
  EXPECT_TRUE(std::any_of(scans.points_m.begin(), scans.points_m.end(), [](const auto& point_m) {
    return std::abs(point_m.x() - 8.0) < 0.25 && std::abs(point_m.y()) < 1e-9;
  }));
}

TEST(CastScans, KeepsOnePointAVoxelAscendingByKey) {
  const ToyWorld world = draw_world(kStreet);
  const VirtualScans scans = must_cast(surface_of(world), world.sites, five_beams());
  for (std::size_t site = 0; site < scans.site_count(); ++site) {
    const std::span<const Eigen::Vector3d> points_m = scans.points_of(site);
    EXPECT_GT(points_m.size(), 50U);
    for (std::size_t i = 1; i < points_m.size(); ++i) {
      EXPECT_LT(cell_key(points_m[i - 1], scans.leaf_m), cell_key(points_m[i], scans.leaf_m));
    }
  }
}

TEST(CastScans, GivesTheSameBytesForAnyNumberOfThreads) {
  ToyWorld world = draw_world(kStreet);
  world.sites.sites.push_back(world.sites.sites[0]);
  world.sites.sites.back().p_map_m.x() += 70.0;
  const Surface surface = surface_of(world);
  EXPECT_EQ(to_bytes(must_cast(surface, world.sites, five_beams(), 1)),
            to_bytes(must_cast(surface, world.sites, five_beams(), 3)));
}

TEST(CastScans, SeesNoFewerPointsWithALongerRange) {
  const ToyWorld world = draw_world(kStreet);
  const Surface surface = surface_of(world);
  std::size_t before = 0;
  for (const double range_m : {3.0, 6.0, 12.0, 24.0}) {
    CastScansOptions options;
    options.longest_range_m = range_m;
    const std::size_t count =
        must_cast(surface, world.sites, five_beams(), 1, options).points_m.size();
    EXPECT_GE(count, before);
    before = count;
  }
}

TEST(CastScans, RefusesASurfaceInAnotherFrameAndNearBeyondFar) {
  const ToyWorld world = draw_world(kStreet);
  Surface surface = surface_of(world);
  PassContext ctx;
  CastScansOptions inverted;
  inverted.near_m = 60.0;
  EXPECT_EQ(cast_scans(ctx, inverted, surface, world.sites, five_beams()).error().code,
            ErrorCode::kBadValue);
  surface.frame.origin_world_m.x() = 64.0;
  EXPECT_EQ(cast_scans(ctx, {}, surface, world.sites, five_beams()).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
