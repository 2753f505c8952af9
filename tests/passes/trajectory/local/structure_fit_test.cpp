#include "passes/trajectory/local/structure_fit.h"

#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "passes/trajectory/local/local_match.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

constexpr std::size_t kScansOfMap = 14;

// A local map of scans 1 m apart along x, and the scan behind them; returns with 1 cm of noise.
struct Place {
  LocalMap map{50.0};
  std::vector<Eigen::Vector3d> points_m;
  Pose T_map_lidar = Pose::Identity();
  Pose T_lidar_vehicle = Pose::Identity();

  [[nodiscard]] std::array<const RollingCells*, 2> grids() const {
    return {&map.details(), &map.grids().fine_cells()};
  }
};

Place place_in(const BoxWorld& world) {
  Random random(7);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i <= kScansOfMap; ++i) {
    poses.push_back(pose_at(static_cast<double>(i), 0.3, 0.02));
  }
  TestDrive test = drive_through(world, poses, 0.5);
  add_noise(0.01, random, test);
  Place place;
  const Pose& T_vehicle_lidar = test.drive.sensor.T_vehicle_lidar;
  for (std::size_t k = 0; k < kScansOfMap; ++k) {
    place.map.add(read_thinned(test.drive, k)->to_map_m, poses[k] * T_vehicle_lidar,
                  static_cast<double>(k));
  }
  place.points_m = read_thinned(test.drive, kScansOfMap)->to_map_m;
  place.T_map_lidar = poses.back() * T_vehicle_lidar;
  place.T_lidar_vehicle = T_vehicle_lidar.inverse();
  return place;
}

// Walls on both sides with pillars that stand out by 1 m.
BoxWorld street_with_pillars() {
  BoxWorld world = bare_street();
  for (const double x_m : {-3.3, 8.2, 21.6}) {
    world.boxes.push_back({{x_m, 5.0, 0.0}, {x_m + 1.4, 6.0, 5.0}});
    world.boxes.push_back({{x_m + 5.0, -6.0, 0.0}, {x_m + 6.4, -5.0, 5.0}});
  }
  return world;
}

// Where the fit ends from a forecast that is off by a motion, relative to the truth: forward, left
// and turn.
PlanarMotion error_after_fit(const Place& place, const PlanarMotion& off_m, double sigma_m) {
  const Pose T_map_vehicle = place.T_map_lidar * place.T_lidar_vehicle;
  const FitStart start{moved_in_plane(T_map_vehicle, off_m) * place.T_lidar_vehicle.inverse(),
                       {PlanarMotion::UnitX()},
                       PlanarMotion::Constant(sigma_m)};
  const Pose fitted = fit_structure(place.grids(), place.points_m, start, place.T_lidar_vehicle);
  return planar_motion(T_map_vehicle, fitted * place.T_lidar_vehicle);
}

TEST(StructureFit, TakesTheForecastAlongBareWallsAndTheWallsAcross) {
  const Place place = place_in(bare_street());
  for (const double ahead_m : {-0.2, 0.0, 0.1}) {
    const PlanarMotion error = error_after_fit(place, {ahead_m, 0.06, 0.05}, 0.05);
    EXPECT_NEAR(error[0], ahead_m, 0.01);
    EXPECT_NEAR(error[1], 0.0, 0.01);
    EXPECT_NEAR(error[2], 0.0, 0.02);
  }
}

TEST(StructureFit, MeasuresTheWayByPillars) {
  const Place place = place_in(street_with_pillars());
  for (const double ahead_m : {-0.15, 0.0, 0.1}) {
    const PlanarMotion error = error_after_fit(place, {ahead_m, 0.06, 0.05}, 0.05);
    EXPECT_NEAR(error[0], 0.0, 0.02) << ahead_m;
    EXPECT_NEAR(error[1], 0.0, 0.01) << ahead_m;
  }
}

TEST(StructureFit, OfAMoreAccurateForecastIsNearerToIt) {
  const Place place = place_in(street_with_pillars());
  double last_m = 0.0;
  for (const double sigma_m : {0.1, 0.01, 0.003, 0.0005}) {
    const double ahead_m = error_after_fit(place, {0.1, 0.0, 0.0}, sigma_m)[0];
    EXPECT_GT(ahead_m, last_m - 0.001) << sigma_m;
    last_m = ahead_m;
  }
  EXPECT_NEAR(last_m, 0.1, 0.01);
}

TEST(MetSurface, HasTheDerivativesOfItsDistance) {
  const Place place = place_in(street_with_pillars());
  const Pose T_map_vehicle = place.T_map_lidar * place.T_lidar_vehicle;
  const Pose T_vehicle_lidar = place.T_lidar_vehicle.inverse();
  const auto met_after = [&](const LevelMotion& motion) {
    return met_surfaces(place.grids(), place.points_m,
                        moved_level(T_map_vehicle, motion) * T_vehicle_lidar,
                        place.T_lidar_vehicle);
  };
  constexpr double kStep = 1e-9;
  const std::vector<MetSurface> here = met_after(LevelMotion::Zero());
  ASSERT_GT(here.size(), 100U);
  for (int i = 0; i < 6; ++i) {
    const std::vector<MetSurface> above = met_after(kStep * LevelMotion::Unit(i));
    const std::vector<MetSurface> below = met_after(-kStep * LevelMotion::Unit(i));
    ASSERT_EQ(above.size(), here.size());
    ASSERT_EQ(below.size(), here.size());
    for (std::size_t j = 0; j < here.size(); ++j) {
      const double derivative = (above[j].distance_m - below[j].distance_m) / (2.0 * kStep);
      EXPECT_NEAR(derivative, here[j].by_motion[i], 1e-5) << i << ", " << j;
    }
  }
}

// Normals of bare walls are up to 9 degrees off by noise, and those of pillars are not.
TEST(MetSurface, HoldsAMotionClearlyBeyondTheNoiseOfItsNormal) {
  const PlanarMotion along = PlanarMotion::UnitX();
  const auto count_in = [&](const BoxWorld& world) {
    const Place place = place_in(world);
    int count = 0;
    for (const MetSurface& one :
         met_surfaces(place.grids(), place.points_m, place.T_map_lidar, place.T_lidar_vehicle)) {
      count += one.clearly_holds(along) ? 1 : 0;
    }
    return count;
  };
  EXPECT_LT(count_in(bare_street()), 10) << "of 1000 and more";
  EXPECT_GT(count_in(street_with_pillars()), 20);
}

}  // namespace
}  // namespace sightline
