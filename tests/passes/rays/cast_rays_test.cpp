#include "passes/rays/cast_rays.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "passes/map/build_surface.h"
#include "tests/support/test_context.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

const char* const kStreet = R"(
##############################
..............................
....@...@...@...@...o....@....
..............................
##############################
)";

Surface surface_of(const ToyWorld& world, double tile_m = 64.0) {
  const BuildSurfaceOptions options{.tile_m = tile_m};
  return value_of(whole_rows(build_surface(TestContext(), options, world.points)));
}

DepthImages must_cast(const Surface& surface, const Sites& sites, int threads = 1,
                      const CastRaysOptions& options = {}, double view_deg = 360.0) {
  SensorProfile sensor;
  sensor.azimuth_view_deg = view_deg;
  const DepthImages images =
      value_of(cast_rays(TestContext(threads), options, surface, sites, sensor));
  EXPECT_TRUE(validate(images).has_value());
  return images;
}

double distance_m(const DepthImages& images, std::size_t site, int azimuth_deg, int elevation_deg) {
  return images.image_of(site)[static_cast<std::size_t>((elevation_deg + 15) * 360 + azimuth_deg)];
}

TEST(CastRays, SeesWallsAndGroundWhereTheyWereDrawn) {
  const ToyWorld world = draw_world(kStreet);
  const DepthImages images = must_cast(surface_of(world), world.sites);
  // Across the street, 1.5 m to either wall, cell centres half a degree off the axis.
  const double half_rad = 0.5 * std::numbers::pi / 180.0;
  EXPECT_NEAR(distance_m(images, 2, 90, 0), 1.5 / std::cos(half_rad), 0.02);
  EXPECT_NEAR(distance_m(images, 2, 270, 0), 1.5 / std::cos(half_rad), 0.02);
  // Ten degrees down along the street: the ground is 1.8 m below.
  EXPECT_NEAR(distance_m(images, 0, 0, -10), 1.8 / std::sin(10.0 * std::numbers::pi / 180.0), 0.05);
  // Level along the street, to the side of the pole: nothing.
  EXPECT_EQ(distance_m(images, 2, 2, 1), std::numeric_limits<double>::infinity());
}

TEST(CastRays, PutsThePoleWhereItStands) {
  const ToyWorld world = draw_world(kStreet);
  const DepthImages images = must_cast(surface_of(world), world.sites);
  // The fourth site is 4 m before the pole, which hides what lies beyond.
  EXPECT_NEAR(std::min(distance_m(images, 3, 0, 0), distance_m(images, 3, 359, 0)), 4.0, 0.25);
}

TEST(CastRays, GivesTheSameBytesForAnyTilesAndThreads) {
  ToyWorld world = draw_world(kStreet);
  // Twice the street, so that sites lie in two blocks of geometry.
  ToyWorld far = draw_world(kStreet);
  for (Eigen::Vector3d& point_m : far.points.points_m) {
    world.points.points_m.emplace_back(point_m + Eigen::Vector3d(90.0, 0.0, 0.0));
  }
  for (Site& site : far.sites.sites) {
    site.p_map_m.x() += 90.0;
    world.sites.sites.push_back(site);
  }
  const DepthImages one = must_cast(surface_of(world), world.sites);
  EXPECT_EQ(to_bytes(one), to_bytes(must_cast(surface_of(world), world.sites, 3)));
  EXPECT_EQ(to_bytes(one), to_bytes(must_cast(surface_of(world, 32.0), world.sites)));
}

TEST(CastRays, NeverSeesFurtherThanItIsAskedTo) {
  const ToyWorld world = draw_world(kStreet);
  const Surface surface = surface_of(world);
  const CastRaysOptions options{.longest_range_m = 10.0};
  const DepthImages near = must_cast(surface, world.sites, 1, options);
  const DepthImages far = must_cast(surface, world.sites);
  for (std::size_t i = 0; i < near.distance_m.size(); ++i) {
    if (far.distance_m[i] < 9.999F) {
      EXPECT_EQ(near.distance_m[i], far.distance_m[i]);
    } else if (far.distance_m[i] > 10.001F) {
      EXPECT_FALSE(std::isfinite(near.distance_m[i]));
    }
  }
}

TEST(CastRays, RefusesASurfaceInAnotherFrame) {
  const ToyWorld world = draw_world(kStreet);
  Surface surface = surface_of(world);
  surface.frame.origin_world_m.x() = 64.0;
  EXPECT_EQ(failure_of(cast_rays(TestContext(), {}, surface, world.sites, SensorProfile())).code,
            ErrorCode::kMismatchedInputs);
}

TEST(CastRays, RefusesElevationsBeyondThePoleAndNearBeyondFar) {
  const ToyWorld world = draw_world(kStreet);
  const Surface surface = surface_of(world);
  const CastRaysOptions beyond_pole{.elevation_count = 120};
  EXPECT_EQ(
      cast_rays(TestContext(), beyond_pole, surface, world.sites, SensorProfile()).error().code,
      ErrorCode::kBadValue);
  const CastRaysOptions inverted{.near_m = 60.0};
  EXPECT_EQ(cast_rays(TestContext(), inverted, surface, world.sites, SensorProfile()).error().code,
            ErrorCode::kBadValue);
}

TEST(CastRays, LeavesOutWhatTheSensorHasNotInView) {
  ToyWorld world = draw_world(kStreet);
  const double heading_deg = 100.0;
  for (Site& site : world.sites.sites) {
    site.T_map_vehicle.rotate(
        Eigen::AngleAxisd(heading_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  }
  const Surface surface = surface_of(world);
  const DepthImages round = must_cast(surface, world.sites);
  const DepthImages ahead = must_cast(surface, world.sites, 3, {}, 70.4);
  for (std::size_t i = 0; i < round.distance_m.size(); ++i) {
    const double azimuth_deg = static_cast<double>(i % 360) + 0.5;
    if (std::abs(azimuth_deg - heading_deg) <= 35.2) {
      EXPECT_EQ(ahead.distance_m[i], round.distance_m[i]) << i;
    } else {
      EXPECT_TRUE(std::isnan(ahead.distance_m[i])) << i;
    }
  }
}

}  // namespace
}  // namespace sightline
