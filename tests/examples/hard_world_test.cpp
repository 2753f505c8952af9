#include "examples/town/world/hard/hard_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "examples/town/drive/constraint.h"
#include "tests/examples/hard_world.h"

namespace sightline::town {
namespace {

std::vector<std::string_view> hard_worlds() {
  std::vector<std::string_view> names = world_kind_names();
  std::erase(names, "town");
  return names;
}

bool same_mesh(const TownMesh& a, const TownMesh& b) {
  return a.vertices_m == b.vertices_m && a.triangles == b.triangles && a.labels == b.labels;
}

TEST(HardWorld, OfEveryKindIsMadeFromItsSeedAlone) {
  for (const std::string_view name : hard_worlds()) {
    const Town town = hard_town(name, 120.0);
    EXPECT_TRUE(same_mesh(standing_mesh(town, 1), standing_mesh(hard_town(name, 120.0), 1)))
        << name;
    EXPECT_FALSE(same_mesh(town.permanent, hard_town(name, 120.0, 5).permanent)) << name;
    ASSERT_EQ(town.permanent.labels.size(), town.permanent.triangles.size());
    for (const Eigen::Vector3f& vertex : town.permanent.vertices_m) {
      ASSERT_TRUE(vertex.allFinite()) << name;
    }
  }
}

TEST(HardWorld, IsSeenAndConstrainedWhereItBeginsAndEnds) {
  bool is_end = false;
  for (const std::string_view name : hard_worlds()) {
    const Town town = hard_town(name, 120.0);
    DriveOptions options = hard_drive_options(town);
    options.spacing_m = 30.0;
    const DriveSimulator drive = value_of(DriveSimulator::make(town, options));
    const std::size_t scan = is_end ? drive.scan_count() - 1 : 0;  // one of each: they take long
    is_end = !is_end;
    const Constraint found = constraint_of(drive, scan);
    EXPECT_LT(found.kept_ahead, 0.1) << name << " " << scan;
    EXPECT_LT(found.kept_left, 0.1) << name << " " << scan;
    EXPECT_LT(found.sigma_ahead_m, 0.005) << name << " " << scan;
    const std::size_t returns = drive.scan(2).points.size();
    EXPECT_GT(returns, 3000U) << name;
    EXPECT_LE(returns, 28800U) << name;
  }
}

TEST(HardWorld, OfASmoothRoadIsConstrainedAcrossItAlone) {
  for (const std::string_view name : {"tunnel", "motorway", "noise-barrier", "bridge"}) {
    const Town town = hard_town(name, 300.0, 4);
    DriveOptions options = hard_drive_options(town);
    options.from_m = 150.0;
    options.length_m = 1.0;
    const DriveSimulator drive = value_of(DriveSimulator::make(town, options));
    const Constraint found = constraint_of(drive, 0);
    EXPECT_GT(found.kept_ahead, 0.5) << name;
    EXPECT_LT(found.kept_left, 0.3) << name;
    EXPECT_GT(found.sigma_ahead_m, 20.0 * found.sigma_left_m) << name;
  }
}

TEST(HardWorld, OfMixedPlacesHasEveryKindOnceAndTownsAtBothEnds) {
  const WorldKind mixed = *world_kind("mixed");
  EXPECT_EQ(usual_length_m(mixed), 1280.0);
  std::set<std::vector<PlaceKind>> orders;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const std::vector<Place> places = order_places(seed, {mixed, false, 1280.0});
    ASSERT_EQ(places.size(), 12U);
    EXPECT_EQ(places.front().kind, PlaceKind::kTown);
    EXPECT_EQ(places.back().kind, PlaceKind::kTown);
    EXPECT_EQ(places.back().to_m, 1280.0);
    std::vector<PlaceKind> order;
    for (std::size_t i = 1; i + 1 < places.size(); ++i) {
      EXPECT_NEAR(places[i].length_m(), 120.0, 1e-9);
      EXPECT_EQ(places[i].from_m, places[i - 1].to_m);
      order.push_back(places[i].kind);
    }
    EXPECT_EQ(std::set<PlaceKind>(order.begin(), order.end()).size(), 10U);
    orders.insert(order);
  }
  EXPECT_GT(orders.size(), 3U);
  EXPECT_EQ(order_places(1, {mixed, true, 240.0}).size(), 2U);
}

TEST(HardWorld, OfMixedPlacesNeverMeetsItself) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const std::vector<Place> places = order_places(seed, {*world_kind("mixed"), false, 1280.0});
    const DrivenLine line = make_road_line(seed, places);
    ASSERT_GE(line.length_m(), 1280.0);
    for (double s = 0.0; s < 1280.0; s += 5.0) {
      for (double later = s + 100.0; later < 1280.0; later += 5.0) {
        const bool is_inside = place_at(places, s).kind == PlaceKind::kCarPark ||
                               place_at(places, later).kind == PlaceKind::kCarPark;
        if (is_inside) continue;
        ASSERT_GT((line.at(s).position_m - line.at(later).position_m).norm(), 25.0)
            << "seed " << seed << " at " << s << " and " << later;
      }
    }
  }
}

TEST(HardWorld, RoadsAreSmoothAndAsLongAsTheySay) {
  const Town town = hard_town("mixed", 1280.0);
  const Road road = town.road();
  constexpr double kStep_m = 0.01;
  for (double s_m = 0.1; s_m < 1279.0; s_m += 0.13) {
    const RoadPoint a = road.at(s_m);
    const RoadPoint b = road.at(s_m + kStep_m);
    const Eigen::Vector3d step_m = b.position_m - a.position_m;
    ASSERT_NEAR(step_m.head<2>().norm(), kStep_m, 1e-5) << s_m;
    ASSERT_NEAR(step_m.z() / kStep_m, 0.5 * (a.slope + b.slope), 1e-5) << s_m;
    ASSERT_LT((step_m.head<2>() / kStep_m - direction(a.heading_rad)).norm(), 0.011) << s_m;
  }
}

TEST(HardWorld, HillsHaveSlopesOfFourPercent) {
  const Town town = hard_town("hills", 300.0);
  const DriveSimulator drive = value_of(DriveSimulator::make(town, hard_drive_options(town)));
  double steepest_up = 0.0;
  double steepest_down = 0.0;
  double highest_m = 0.0;
  for (const Pose& pose : drive.T_town_vehicle()) {
    steepest_up = std::max(steepest_up, pose.linear()(2, 0));
    steepest_down = std::min(steepest_down, pose.linear()(2, 0));
    highest_m = std::max(highest_m, pose.translation().z());
  }
  EXPECT_NEAR(steepest_up, 0.04, 0.015);  // and the unevenness of the ground
  EXPECT_NEAR(steepest_down, -0.04, 0.015);
  EXPECT_GT(highest_m, 1.5);
}

TEST(CarParkWorld, HasThreeStoreysAboveEachOtherIn300Metres) {
  const Town town = hard_town("car-park", 300.0);
  const Place& place = town.places[1];
  const CarPark car_park = car_park_of(place);
  ASSERT_EQ(car_park.loops, 2);
  const Road road = town.road();
  const double loop_m = car_park.ramp_from_m(1) - car_park.ramp_from_m(0);
  const TownCaster caster(town.permanent);
  for (double along_m = 1.0; along_m < car_park.straight_m; along_m += 3.0) {
    const double s_m = place.from_m + CarPark::kApproach_m + along_m;
    for (int storey = 0; storey < 3; ++storey) {
      const RoadPoint point = road.at(s_m + storey * loop_m);
      const Eigen::Vector3d above = point.position_m - road.at(s_m).position_m;
      EXPECT_LT(above.head<2>().norm(), 1e-3);
      EXPECT_NEAR(above.z(), 2.75 * storey, 1e-6);
      // A floor below and a ceiling above, wherever the car is.
      const Eigen::Vector3d sensor_m = point.position_m + Eigen::Vector3d(0.0, 0.0, 1.8);
      EXPECT_NEAR(caster.exact_range_m(sensor_m, -Eigen::Vector3d::UnitZ()), 1.8, 1e-3);
      EXPECT_NEAR(caster.exact_range_m(sensor_m, Eigen::Vector3d::UnitZ()), 0.7, 1e-3);
    }
  }
}

TEST(CarParkWorld, IsDrivenThroughWithoutTouchingAnything) {
  const Town town = hard_town("car-park", 300.0);
  const Road road = town.road();
  const TownCaster caster(standing_mesh(town, 0));
  for (double s_m = 30.0; s_m < 270.0; s_m += 0.5) {
    const RoadPoint point = road.at(s_m);
    const Eigen::Vector2d left = left_of(direction(point.heading_rad));
    const Eigen::Vector3d hip_m = point.position_m + Eigen::Vector3d(0.0, 0.0, 0.7);
    for (const double side : {1.0, -1.0}) {
      const Eigen::Vector3d across(side * left.x(), side * left.y(), 0.0);
      ASSERT_GT(caster.exact_range_m(hip_m, across), 1.1) << s_m;
    }
    ASSERT_NEAR(caster.exact_range_m(hip_m, -Eigen::Vector3d::UnitZ()), 0.7, 0.15) << s_m;
  }
}

TEST(CarParkWorld, HalfOfTheCarsChangeBetweenDrives) {
  const Town town = bare_town("car-park", 220.0);
  const auto cars = [&](std::uint64_t drive) {
    const TownMesh mesh = standing_mesh(town, drive);
    std::set<std::array<float, 6>> pieces;  // extent of each triangle
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (mesh.labels[t] != Label::kParkedCar) continue;
      const Eigen::Vector3f& a = mesh.vertices_m[mesh.triangles[t][0]];
      const Eigen::Vector3f& b = mesh.vertices_m[mesh.triangles[t][2]];
      pieces.insert({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()});
    }
    return pieces;
  };
  const std::set<std::array<float, 6>> before = cars(0);
  EXPECT_EQ(before, cars(0));
  for (const std::uint64_t drive : {1ULL, 2ULL}) {
    const std::set<std::array<float, 6>> after = cars(drive);
    const auto kept = static_cast<double>(
        std::ranges::count_if(before, [&](const auto& piece) { return after.contains(piece); }));
    EXPECT_NEAR(kept / static_cast<double>(before.size()), 0.5, 0.15) << drive;
    EXPECT_NEAR(static_cast<double>(after.size()) / static_cast<double>(before.size()), 1.0, 0.25);
  }
}

TEST(HardWorld, RefusesWhatItCannotBe) {
  TownOptions round = hard_options("tunnel", 300.0);
  round.is_round = true;
  EXPECT_EQ(code_of(make_town(round)), ErrorCode::kBadArgument);
  EXPECT_EQ(code_of(make_town(hard_options("field", 119.0))), ErrorCode::kBadArgument);
  TownOptions bare = hard_options("field", 40.0);
  bare.is_bare = true;
  EXPECT_TRUE(make_town(bare).has_value());
  EXPECT_FALSE(world_kind("desert").has_value());
  const Town field = hard_town("field", 120.0);
  DriveOptions next_lane = hard_drive_options(field);
  next_lane.is_in_next_lane = true;
  EXPECT_EQ(code_of(DriveSimulator::make(field, next_lane)), ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline::town
