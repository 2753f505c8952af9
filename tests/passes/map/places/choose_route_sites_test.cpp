#include "passes/map/places/choose_route_sites.h"

#include <gtest/gtest.h>

#include "passes/map/places/ground_floors.h"
#include "tests/passes/map/places/level_street.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

RouteLine line(double from_m, double to_m, RouteHeights heights = RouteHeights::kNone,
               double height_m = 0.0) {
  return {"lane", heights, false, {{640.0 + from_m, 0.0, height_m}, {640.0 + to_m, 0.0, height_m}}};
}

Result<Sites> choose(TestContext& ctx, const Surface& surface,
                     const std::vector<RouteLine>& lines) {
  return choose_route_sites(ctx, {}, {"lanes.osm", lines, {}}, surface, sensor_ahead());
}

ChosenSites chosen(const Surface& surface, const std::vector<RouteLine>& lines) {
  TestContext ctx;
  return {value_of(choose(ctx, surface, lines)), std::move(ctx.warnings)};
}

Error refusal(const Surface& surface, const RouteLine& along) {
  TestContext ctx;
  return failure_of(choose(ctx, surface, {along}));
}

TEST(ChooseRouteSites, StandOnTheGroundEveryMetreAndLookAlongTheLine) {
  const auto [sites, warnings] = chosen(level_street(), {line(10.0, 20.0)});
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  ASSERT_TRUE(validate(sites).has_value());
  ASSERT_EQ(sites.sites.size(), 11U);
  const Site& site = sites.sites[3];
  EXPECT_EQ(site.s_m, 3.0);
  EXPECT_LT((site.T_map_vehicle.translation() - Eigen::Vector3d(13.0, 0.0, 0.1)).norm(), 1e-12);
  EXPECT_LT((site.p_map_m - Eigen::Vector3d(13.5, 0.0, 1.9)).norm(), 1e-12);
  EXPECT_EQ(site.T_map_vehicle.linear(), Eigen::Matrix3d::Identity());
}

TEST(ChooseRouteSites, ALaneOfBothWaysIsAnnotatedInBoth) {
  RouteLine both = line(10.0, 20.0);
  both.is_both_ways = true;
  const auto [sites, warnings] = chosen(level_street(), {both});
  ASSERT_EQ(sites.sites.size(), 22U);
  EXPECT_EQ(sites.sites.back().run, 1U);
  EXPECT_EQ(sites.sites.back().T_map_vehicle.linear()(0, 0), -1.0);
  EXPECT_LT((sites.sites.back().p_map_m - Eigen::Vector3d(9.5, 0.0, 1.9)).norm(), 1e-12);
}

TEST(ChooseRouteSites, AVehiclesOwnHeightsAreKept) {
  const auto [sites, warnings] =
      chosen(level_street(), {line(10.0, 20.0, RouteHeights::kVehicle, 0.3)});
  EXPECT_LT(std::abs(sites.sites[0].T_map_vehicle.translation().z() - 0.3), 1e-12);
}

TEST(ChooseRouteSites, WhatLiesOffTheMapIsLeftOutAndCounted) {
  const auto [sites, warnings] = chosen(level_street(), {line(40.0, 90.0)});
  EXPECT_EQ(sites.sites.size(), 10U);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("21 of 51 places"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("off the map"), std::string::npos);
  EXPECT_NE(warnings[1].find("without ground"), std::string::npos);
}

// From 10 to 16 m and from 25 to 42 m.
Surface street_with_holes() {
  Surface surface = level_street();
  std::erase_if(surface.patches, [](const SurfacePatch& patch) {
    const double x_m = patch.centre_m.x();
    return (x_m > 10.0 && x_m < 16.0) || (x_m > 25.0 && x_m < 42.0);
  });
  return surface;
}

TEST(ChooseRouteSites, AShortHoleIsBridgedAndALongOneEndsTheRun) {
  const auto [sites, warnings] = chosen(street_with_holes(), {line(0.0, 50.0)});
  EXPECT_EQ(sites.sites.back().run, 1U);
  EXPECT_EQ(sites.sites[13].run, 0U);
  EXPECT_NEAR(sites.sites[13].p_map_m.z(), 1.9, 1e-12);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("without ground"), std::string::npos) << warnings[0];
}

void add_told_floor(double from_m, double to_m, double height_m, Surface& surface) {
  const std::size_t first = surface.patches.size();
  add_floor(box(from_m, -5.0, to_m, 5.0), height_m, surface);
  for (std::size_t i = first; i < surface.patches.size(); ++i) {
    surface.patches[i].half_side_m = surface.cell_m;
  }
}

TEST(ChooseRouteSites, GroundThatNobodySawCarriesNobodyOverALongHoleOrBeyondTheMap) {
  Surface holed = street_with_holes();
  add_told_floor(10.0, 16.0, 0.1, holed);
  add_told_floor(25.0, 42.0, 0.1, holed);
  add_told_floor(50.0, 55.0, 0.1, holed);
  const auto [sites, warnings] = chosen(holed, {line(0.0, 60.0)});
  EXPECT_EQ(sites.sites[13].run, 0U) << "a short hole is bridged";
  for (const Site& site : sites.sites) {
    const double x_m = site.T_map_vehicle.translation().x();
    EXPECT_FALSE(x_m > 26.5 && x_m < 40.5) << x_m;
    EXPECT_LT(x_m, 51.5);
  }
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("without ground"), std::string::npos) << warnings[0];
}

// A bridge over the middle of the street.
TEST(ChooseRouteSites, TheFloorIsThatWhichTheLineComesFrom) {
  Surface bridged = level_street();
  add_floor(box(20.0, -5.0, 30.0, 5.0), 6.0, bridged);
  const auto [below, warnings] = chosen(bridged, {line(1.0, 49.0)});
  EXPECT_EQ(below.sites.size(), 49U);
  for (const Site& site : below.sites) EXPECT_NEAR(site.p_map_m.z(), 1.9, 1e-9);
  const auto [above, none] = chosen(bridged, {line(22.0, 28.0, RouteHeights::kRoad, 5.8)});
  for (const Site& site : above.sites) EXPECT_NEAR(site.p_map_m.z(), 7.8, 1e-9);
}

TEST(ChooseRouteSites, RefusesARouteThatTheMapSaysNothingOf) {
  Surface two_floors = level_street();
  add_floor(box(0.0, -5.0, 50.0, 5.0), 6.0, two_floors);
  EXPECT_EQ(refusal(two_floors, line(10.0, 20.0)).code, ErrorCode::kTwoFloors);
  Surface walls = level_street();
  for (SurfacePatch& patch : walls.patches) patch.normal = Eigen::Vector3d::UnitX();
  EXPECT_EQ(refusal(walls, line(10.0, 20.0)).code, ErrorCode::kNoGround);
  EXPECT_EQ(refusal(level_street(), line(10.0, 20.0, RouteHeights::kRoad, 45.0)).code,
            ErrorCode::kNoGround);
  // A kilometre away, as lanes of another projection are.
  const Error away = refusal(level_street(), line(1050.0, 1100.0));
  EXPECT_EQ(away.code, ErrorCode::kNoOverlap);
  EXPECT_NE(away.message.find("1000 m"), std::string::npos) << away.message;
}

// A parked car's roof, a low branch and a shard are no floor.
TEST(GroundFloors, OnlyWhatAVehicleCouldStandOnIsAFloor) {
  Surface surface = level_street();
  add_floor(box(10.0, -5.0, 14.0, 5.0), 1.4, surface);
  EXPECT_EQ(GroundFloors(surface).at({12.0, 0.0}), std::vector<double>{0.1});
  Surface shards = level_street();
  for (SurfacePatch& patch : shards.patches) patch.solid = 1;
  EXPECT_TRUE(GroundFloors(shards).at({12.0, 0.0}).empty());
}

}  // namespace
}  // namespace sightline
