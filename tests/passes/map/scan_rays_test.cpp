#include "passes/map/scan_rays.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr double kTouch_m = 0.1;

Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

double any_azimuth(Random& random) { return random.uniform(-std::numbers::pi, std::numbers::pi); }

std::vector<Eigen::Vector3d> returns_of_beams(Random& random) {
  std::vector<Eigen::Vector3d> points_m;
  for (int beam = -8; beam < 8; ++beam) {
    for (int step = 0; step < 900; ++step) {
      const double azimuth_rad = step * std::numbers::pi / 450.0;
      const double range_m = random.uniform(2.0, 80.0);
      if (random.uniform() < 0.3) continue;
      points_m.emplace_back(range_m * direction_of(azimuth_rad, 0.035 * beam + 0.017));
    }
  }
  return points_m;
}

std::vector<Eigen::Vector3d> returns_anywhere(Random& random, int count) {
  std::vector<Eigen::Vector3d> points_m = {{0.0, 0.0, 30.0}, {0.0, 0.0, -2.0}, {1e-9, 0.0, 7.0}};
  for (int i = 0; i < count; ++i) {
    const double elevation_rad = std::asin(random.uniform(-1.0, 1.0));
    points_m.emplace_back(random.uniform(0.5, 90.0) *
                          direction_of(any_azimuth(random), elevation_rad));
  }
  return points_m;
}

// Beside rays as often as anywhere; some at the sensor.
std::vector<Eigen::Vector3d> places_near(const std::vector<Eigen::Vector3d>& returns_m,
                                         Random& random) {
  std::vector<Eigen::Vector3d> places_m = {Eigen::Vector3d::Zero(), {0.05, 0.0, 0.02}};
  for (int i = 0; i < 1000; ++i) {
    const double elevation_rad = std::asin(random.uniform(-1.0, 1.0));
    const Eigen::Vector3d any =
        direction_of(any_azimuth(random), elevation_rad) * random.uniform(0.0, 70.0);
    const Eigen::Vector3d beside = returns_m[random.below(returns_m.size())] * random.uniform() +
                                   0.03 * any.normalized() * random.uniform(0.0, 5.0);
    places_m.push_back(i % 2 == 0 ? any : beside);
  }
  return places_m;
}

bool passes(const Eigen::Vector3d& end_m, const RayQuery& query) {
  const double range_m = end_m.norm();
  const Eigen::Vector3d direction = end_m / range_m;
  const double along_m = query.at_m.dot(direction);
  if (!(along_m > 0.0) || range_m < along_m + ScanRays::kEndMargin_m) return false;
  const Eigen::Vector3d beside_m = query.at_m - along_m * direction;
  if (beside_m.norm() > query.touch_m) return false;
  if (query.up.dot(end_m) < query.lowest_end_m) return false;
  return query.least_below_m <= 0.0 || query.up.dot(beside_m) >= query.least_below_m;
}

bool passes(const std::vector<Eigen::Vector3d>& ends_m, const RayQuery& query) {
  return std::any_of(ends_m.begin(), ends_m.end(),
                     [&](const Eigen::Vector3d& end_m) { return passes(end_m, query); });
}

std::vector<std::vector<Eigen::Vector3d>> some_scans(Random& random) {
  return {returns_of_beams(random), returns_anywhere(random, 5000), returns_anywhere(random, 0)};
}

TEST(ScanRays, SaysWhatEveryRayByItselfSays) {
  Random random(1);
  ScanRays rays;
  for (const std::vector<Eigen::Vector3d>& returns_m : some_scans(random)) {
    rays.take(returns_m);
    int yes = 0;
    for (const Eigen::Vector3d& at_m : places_near(returns_m, random)) {
      RayQuery query{at_m, random.uniform(0.02, 0.3)};
      if (random.uniform() < 0.3) query.least_below_m = 0.01;
      if (random.uniform() < 0.3) query.lowest_end_m = random.uniform(-5.0, 5.0);
      query.up = (Eigen::Vector3d::UnitZ() + 0.05 * Eigen::Vector3d::UnitX()).normalized();
      const bool expected = passes(returns_m, query);
      ASSERT_EQ(rays.pass_through(query), expected) << at_m.transpose();
      yes += expected ? 1 : 0;
    }
    EXPECT_GT(yes, 100);
  }
}

struct MapPlaces {
  std::vector<float> x_m, y_m, z_m;
  RayPlaces places;

  MapPlaces(const std::vector<Eigen::Vector3d>& places_lidar_m, const Pose& T_map_lidar,
            const Eigen::Vector3d& anchor_m) {
    places.anchor_m = anchor_m;
    for (const Eigen::Vector3d& place_m : places_lidar_m) {
      const Eigen::Vector3f from_m = (T_map_lidar * place_m - anchor_m).cast<float>();
      x_m.push_back(from_m.x());
      y_m.push_back(from_m.y());
      z_m.push_back(from_m.z());
      places.radius_m = std::max(places.radius_m, from_m.norm());
    }
    places.x_m = x_m;
    places.y_m = y_m;
    places.z_m = z_m;
  }
};

TEST(ScanRays, FindsEveryPlaceThatARayPasses) {
  Random random(2);
  Pose T_map_lidar = Pose::Identity();
  T_map_lidar.translation() = Eigen::Vector3d(81234.5, -4321.25, 217.0);
  T_map_lidar.linear() =
      Eigen::AngleAxisd(1.3, Eigen::Vector3d(0.03, -0.02, 1.0).normalized()).toRotationMatrix();
  ScanRays rays;
  std::vector<std::uint32_t> found;
  for (const std::vector<Eigen::Vector3d>& returns_m : some_scans(random)) {
    rays.take(returns_m);
    for (const double anchor_m : {0.0, 3.0, 50.0}) {
      const std::vector<Eigen::Vector3d> places_m = places_near(returns_m, random);
      const MapPlaces in_map(
          places_m, T_map_lidar,
          T_map_lidar.translation() + anchor_m * direction_of(any_azimuth(random), 0.1));
      rays.find_passable(in_map.places, T_map_lidar.inverse(), kTouch_m, found);
      ASSERT_TRUE(std::is_sorted(found.begin(), found.end()));
      for (std::uint32_t i = 0; i < places_m.size(); ++i) {
        if (!passes(returns_m, {places_m[i], kTouch_m})) continue;
        EXPECT_TRUE(std::binary_search(found.begin(), found.end(), i))
            << places_m[i].transpose() << " from " << anchor_m;
      }
    }
  }
}

TEST(ScanRays, FindsNoPlaceBetweenBeamsOrBehindWhatTheyHit) {
  // One beam at the horizon, all around, that ends 20 m away.
  std::vector<Eigen::Vector3d> returns_m;
  for (int step = 0; step < 3600; ++step) {
    returns_m.emplace_back(20.0 * direction_of(step * std::numbers::pi / 1800.0, 0.0));
  }
  const ScanRays rays(returns_m);
  const MapPlaces in_map({{10.0, 0.0, 0.0},
                          {10.0, 0.0, 1.0},
                          {0.0, -10.0, 0.0},
                          {0.0, -10.0, -1.0},
                          {0.0, 19.9, 0.0},
                          {0.0, 30.0, 0.0},
                          {-19.0, 0.0, 0.0}},
                         Pose::Identity(), Eigen::Vector3d::Zero());
  std::vector<std::uint32_t> found;
  rays.find_passable(in_map.places, Pose::Identity(), kTouch_m, found);
  EXPECT_EQ(found, (std::vector<std::uint32_t>{0, 2, 6}));
}

TEST(ScanRays, FindsPlacesOnBothSidesOfWhereAzimuthBegins) {
  for (const double y_m : {-0.001, 0.001}) {
    const ScanRays rays(std::vector<Eigen::Vector3d>{{30.0, y_m, 0.0}});
    const MapPlaces in_map({{10.0, 0.05, 0.0}, {10.0, -0.05, 0.0}, {10.0, 1.0, 0.0}},
                           Pose::Identity(), Eigen::Vector3d::Zero());
    std::vector<std::uint32_t> found;
    rays.find_passable(in_map.places, Pose::Identity(), kTouch_m, found);
    EXPECT_EQ(found, (std::vector<std::uint32_t>{0, 1})) << y_m;
  }
}

TEST(ScanRays, WithoutARayFindsNothing) {
  const ScanRays rays(std::vector<Eigen::Vector3d>{});
  const MapPlaces in_map({{10.0, 0.0, 0.0}, {3.0, 0.0, 1.0}}, Pose::Identity(),
                         Eigen::Vector3d::Zero());
  std::vector<std::uint32_t> found = {7};
  rays.find_passable(in_map.places, Pose::Identity(), kTouch_m, found);
  EXPECT_TRUE(found.empty());
  EXPECT_FALSE(rays.pass_through({{10.0, 0.0, 0.0}, kTouch_m}));
  EXPECT_FALSE(rays.pass_through({{0.0, 0.0, 0.0}, kTouch_m}));
}

}  // namespace
}  // namespace sightline
