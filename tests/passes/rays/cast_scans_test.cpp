#include "passes/rays/cast_scans.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "passes/map/build_surface.h"
#include "passes/matching/scan_preparation.h"
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

SensorProfile five_beams() {
  SensorProfile sensor;
  sensor.beam_elevations_deg = {-15.0, -10.0, 0.0, 5.0, 10.0};
  sensor.azimuth_step_deg = 1.0;
  return sensor;
}

Surface surface_of(const ToyWorld& world) {
  return value_of(whole_rows(build_surface(TestContext(), {}, world.points)));
}

VirtualScans must_cast(const Surface& surface, const Sites& sites, const SensorProfile& sensor,
                       int threads = 1, const CastScansOptions& options = {}) {
  const VirtualScans scans =
      value_of(cast_scans(TestContext(threads), options, surface, sites, sensor));
  EXPECT_TRUE(validate(scans).has_value());
  return scans;
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
    const CastScansOptions options{.longest_range_m = range_m};
    const std::size_t count =
        must_cast(surface, world.sites, five_beams(), 1, options).points_m.size();
    EXPECT_GE(count, before);
    before = count;
  }
}

TEST(CastScans, RefusesASurfaceInAnotherFrameAndNearBeyondFar) {
  const ToyWorld world = draw_world(kStreet);
  Surface surface = surface_of(world);
  const CastScansOptions inverted{.near_m = 60.0};
  EXPECT_EQ(cast_scans(TestContext(), inverted, surface, world.sites, five_beams()).error().code,
            ErrorCode::kBadValue);
  surface.frame.origin_world_m.x() = 64.0;
  EXPECT_EQ(cast_scans(TestContext(), {}, surface, world.sites, five_beams()).error().code,
            ErrorCode::kMismatchedInputs);
}

double apart_deg(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * std::numbers::pi)) * 180.0 / std::numbers::pi;
}

// The hits of a sensor that sees all round, those ahead picked out one by one, then thinned.
TEST(CastScans, OfASensorThatLooksAheadAreThoseOfItsViewAtEachHeading) {
  const ToyWorld world = draw_world(kStreet);
  const Surface surface = surface_of(world);
  SensorProfile sensor = five_beams();
  sensor.azimuth_view_deg = 70.4;
  constexpr double kMounted_rad = 0.4;
  sensor.T_vehicle_lidar.linear() =
      Eigen::AngleAxisd(kMounted_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Sites sites = world.sites;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const auto yaw_rad = static_cast<double>(i);
    // A slope does not turn the view.
    sites.sites[i].T_map_vehicle.linear() =
        (Eigen::AngleAxisd(yaw_rad + kMounted_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(-kMounted_rad, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
  }
  const VirtualScans scans = must_cast(surface, sites, sensor);
  const std::vector<Eigen::Vector3d> directions = beam_directions(five_beams());
  std::vector<std::vector<Eigen::Vector3d>> expected(sites.sites.size());
  const TakeDistances take = [&](std::size_t site, std::span<const double> distance_m) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const double azimuth_rad = std::atan2(directions[i].y(), directions[i].x());
      if (apart_deg(azimuth_rad, static_cast<double>(site) + kMounted_rad) > 35.2) continue;
      if (std::isfinite(distance_m[i])) expected[site].emplace_back(distance_m[i] * directions[i]);
    }
  };
  ASSERT_TRUE(cast_at_sites(TestContext(), surface, sites, {directions, 0.5, 50.0}, take));
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const std::vector<Eigen::Vector3d> thinned = voxel_subsample(expected[site], scans.leaf_m);
    EXPECT_GT(thinned.size(), 5U);
    EXPECT_TRUE(std::ranges::equal(scans.points_of(site), thinned)) << site;
  }
}

TEST(CastScans, OfASensorThatLooksStraightUpLieAheadOfTheVehicle) {
  const ToyWorld world = draw_world(kStreet);
  SensorProfile up = five_beams();
  up.azimuth_view_deg = 90.0;
  up.T_vehicle_lidar.linear() =
      Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const Eigen::Vector3d& point_m : must_cast(surface_of(world), world.sites, up).points_m) {
    EXPECT_GT(point_m.x(), 0.0);
  }
}

// Neighbouring rays at the longest range are 0.35, 0.30 and 0.38 m apart, and the next stride would
// take more than 0.4 leaves.
TEST(CastScans, LeavesOutAzimuthsThatEndInTheSameVoxelsAnyway) {
  const auto stride_of = [](double azimuth_step_deg, double longest_range_m, double leaf_m) {
    SensorProfile sensor;
    sensor.azimuth_step_deg = azimuth_step_deg;
    return azimuth_stride({0.5, longest_range_m, leaf_m}, sensor);
  };
  EXPECT_EQ(stride_of(0.2, 50.0, 1.0), 2);
  EXPECT_EQ(stride_of(0.1728, 50.0, 1.0), 2);
  EXPECT_EQ(stride_of(0.44, 50.0, 1.0), 1);
  EXPECT_EQ(stride_of(0.2, 100.0, 1.0), 1);
  EXPECT_EQ(stride_of(0.2, 20.0, 1.0), 5);
  EXPECT_EQ(stride_of(0.2, 50.0, 0.5), 1);
  EXPECT_EQ(stride_of(2.0, 50.0, 0.1), 1);
}

// What two neighbouring azimuth steps of a beam put into a voxel, one of every two puts there too.
TEST(CastScans, MissNoVoxelThatNeighbouringAzimuthsMeet) {
  const ToyWorld world = draw_world(kStreet);
  const Surface surface = surface_of(world);
  SensorProfile fine = five_beams();
  fine.azimuth_step_deg = 0.2;
  const VirtualScans scans = must_cast(surface, world.sites, fine);
  const std::vector<Eigen::Vector3d> directions = beam_directions(fine);
  ASSERT_EQ(directions.size(), 5U * 1800U);
  std::size_t compared = 0;
  const TakeDistances take = [&](std::size_t site, std::span<const double> distance_m) {
    std::set<CellKey> voxels;
    for (const Eigen::Vector3d& sample_m : scans.points_of(site)) {
      voxels.insert(cell_key(sample_m, scans.leaf_m));
    }
    for (std::size_t i = 1; i < directions.size(); ++i) {
      if (i % 1800 == 0 || !std::isfinite(distance_m[i - 1]) || !std::isfinite(distance_m[i])) {
        continue;
      }
      const CellKey voxel = cell_key(distance_m[i] * directions[i], scans.leaf_m);
      if (voxel != cell_key(distance_m[i - 1] * directions[i - 1], scans.leaf_m)) continue;
      EXPECT_TRUE(voxels.contains(voxel)) << "site " << site << ", ray " << i;
      ++compared;
    }
  };
  ASSERT_TRUE(cast_at_sites(TestContext(), surface, world.sites, {directions, 0.5, 50.0}, take));
  EXPECT_GT(compared, 1000U);
}

}  // namespace
}  // namespace sightline
