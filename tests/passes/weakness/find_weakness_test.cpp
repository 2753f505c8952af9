#include "passes/weakness/find_weakness.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <set>

#include "tests/passes/weakness/corridor.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// The corridor as a map of two ranges and one limit, 0.1 m: the sites 1 to 3 are weak, 2 is unmet.
CompiledMap weak_corridor() {
  CompiledMap map;
  map.ndt = corridor_map(false);
  map.sites = corridor_sites();
  map.sites.spacing_m = 10.0;
  map.sensor = corridor_sensor();
  map.ranges.looks = map.predicted.looks = every_return_at({20.0, 50.0});
  map.ranges.promises.resize(1);
  map.ranges.promises[0].limit_m = 0.1;
  map.predicted.limits_m = {0.1};
  const std::size_t count = map.sites.sites.size();
  map.ranges.site_count = map.predicted.site_count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    map.predicted.mean_m.insert(map.predicted.mean_m.end(), {0.09, i >= 1 && i <= 3 ? 0.07 : 0.02});
    map.predicted.within_probability.insert(map.predicted.within_probability.end(), {0.6, 0.9});
    map.ranges.range_index.push_back(1);
    map.ranges.flags.push_back(i == 2 ? kUnmet : 0);
    map.ranges.reasons.push_back(Reason::kModel);
  }
  return map;
}

WeaknessOptions joined() {
  WeaknessOptions options;
  options.stretches.join_m = 10.0;
  return options;
}

Result<Weakness> find(const CompiledMap& map, const WeaknessOptions& options) {
  return find_weakness(TestContext(), options, map);
}

TEST(FindWeakness, TellsWhereWhichWayWhyAndWhatWouldHelp) {
  const Weakness found = value_of(find(weak_corridor(), joined()));
  EXPECT_EQ(found.limit_m, 0.1);
  ASSERT_EQ(found.stretches.size(), 1U);
  const ExplainedStretch& one = found.stretches.front();
  EXPECT_EQ(one.stretch.first_site, 1U);
  EXPECT_EQ(one.stretch.last_site, 3U);
  EXPECT_EQ(one.stretch.worst_site, 2U);
  EXPECT_EQ(one.stretch.unmet_count, 1U);
  EXPECT_DOUBLE_EQ(one.stretch.worst.look.range_m, 50.0);
  EXPECT_NEAR(one.stretch.worst.margin, 0.3, 1e-12);
  EXPECT_EQ(found.weak_m, 30.0);
  EXPECT_EQ(found.unmet_m, 10.0);
  EXPECT_LT(one.loose.off_road_deg, 10.0);
  EXPECT_FALSE(one.loose.is_of_map);
  EXPECT_GT(one.loose.std_m, 2.0 * one.loose.strong_std_m);
  EXPECT_EQ(one.cause, WeakCause::kOneSided);
  ASSERT_FALSE(one.advice.empty());
  EXPECT_GT(one.advice.front().gain, 0.02);
}

TEST(FindWeakness, TakesTheLooseDirectionFromTheMapsOwnFactors) {
  CompiledMap map = weak_corridor();
  map.factors.looks = every_return_at({20.0, 50.0});
  map.factors.factors = {"crlb_heading", "crlb_max", "crlb_min", "crlb_yaw", "rival_score"};
  map.factors.site_count = map.ranges.site_count;
  for (std::uint32_t i = 0; i < map.factors.site_count; ++i) {
    map.factors.values.insert(map.factors.values.end(), {0, 0, 0, 0, 0, 80, .4, .1, .01, .7});
  }
  const Weakness found = value_of(find(map, joined()));
  const ExplainedStretch& one = found.stretches.front();
  EXPECT_TRUE(one.loose.is_of_map);
  EXPECT_EQ(one.loose.heading_deg, 80.0);
  EXPECT_NEAR(one.loose.off_road_deg, 80.0, 1e-9);
  EXPECT_EQ(one.loose.std_m, 0.4);
  EXPECT_EQ(one.rival_score, 0.7);
  ASSERT_FALSE(one.advice.empty());
  EXPECT_NEAR(one.advice.front().std_before_m, 0.4, 1e-12);
}

TEST(FindWeakness, OfAMapThatHoldsSaysWhereItIsThinnest) {
  CompiledMap map = weak_corridor();
  map.ranges.flags.assign(map.ranges.flags.size(), 0);
  WeaknessOptions options;
  options.stretches.least_margin = 0.25;
  const Weakness found = value_of(find(map, options));
  EXPECT_TRUE(found.stretches.empty());
  EXPECT_EQ(found.thinnest_site, 1U);
  EXPECT_NEAR(found.thinnest.margin, 0.3, 1e-12);
}

TEST(FindWeakness, RefusesWhatMakesNoSense) {
  WeaknessOptions other_limit;
  other_limit.stretches.limit_m = 0.2;
  EXPECT_EQ(find(weak_corridor(), other_limit).error().code, ErrorCode::kBadArgument);
  WeaknessOptions nowhere;
  nowhere.advice.farthest_m = 3.0;
  EXPECT_EQ(find(weak_corridor(), nowhere).error().code, ErrorCode::kBadArgument);
  EXPECT_EQ(find(CompiledMap(), {}).error().code, ErrorCode::kBadArgument);
}

UprightSights plenty() {
  UprightSights sights;
  sights.count = 100;
  sights.holding_count = 10;
  sights.nearest_holding_m = 12.0;
  sights.one_sidedness = 0.5;
  return sights;
}

TEST(WeakCause, TakesTheFirstThatHolds) {
  EXPECT_EQ(cause_of(plenty(), 0.3, 50.0), WeakCause::kUnclear);
  EXPECT_EQ(cause_of(plenty(), 0.95, 50.0), WeakCause::kRepeated);
  EXPECT_EQ(cause_of(plenty(), std::nullopt, 50.0), WeakCause::kUnclear);
  UprightSights far = plenty();
  far.nearest_holding_m = 26.0;
  EXPECT_EQ(cause_of(far, 0.3, 50.0), WeakCause::kDistant);
  far.nearest_holding_m.reset();
  EXPECT_EQ(cause_of(far, 0.3, 50.0), WeakCause::kDistant);
  far.one_sidedness = 0.99;
  EXPECT_EQ(cause_of(far, 0.95, 50.0), WeakCause::kOneSided);
  far.count = 3;
  EXPECT_EQ(cause_of(far, 0.95, 50.0), WeakCause::kEmpty);
}

TEST(WeakCause, HasAWordForEach) {
  std::set<std::string_view> words;
  for (int cause = 0; cause < 5; ++cause) words.insert(name_of(static_cast<WeakCause>(cause)));
  EXPECT_EQ(words.size(), 5U);
}

TEST(UprightSights, OfACorridorFaceOneWay) {
  const CorridorScene scene;
  const UprightSights sights = upright_sights(scene.views.front(), scene.nds, 0.0);
  EXPECT_GT(sights.count, 50U);
  EXPECT_EQ(sights.holding_count, 0U);
  EXPECT_FALSE(sights.nearest_holding_m);
  EXPECT_GT(sights.one_sidedness, 0.99);
  // Across the street every one holds; the walls are 8.1 m away.
  const UprightSights across = upright_sights(scene.views.front(), scene.nds, 90.0);
  EXPECT_EQ(across.holding_count, across.count);
  EXPECT_NEAR(*across.nearest_holding_m, 8.2, 0.6);
}

TEST(UprightSights, SeeTheWallThatEndsTheStreet) {
  const CorridorScene scene(true);
  const UprightSights sights = upright_sights(scene.views.front(), scene.nds, 0.0);
  EXPECT_GT(sights.holding_count, 5U);
  EXPECT_NEAR(*sights.nearest_holding_m, 38.1, 0.6);  // from x = 40
}

// The street's walls and ground, by arithmetic: how far each beam should go.
double expected_m(const Eigen::Vector3d& p_m, const Eigen::Vector3d& direction) {
  const double to_wall_m = (kCorridorWall_m - std::abs(p_m.y())) / std::abs(direction.y());
  const double height_m = p_m.z() + to_wall_m * direction.z();
  if (height_m < kCorridorGround_m) return (kCorridorGround_m - p_m.z()) / direction.z();
  return height_m > kCorridorTop_m ? std::numeric_limits<double>::infinity() : to_wall_m;
}

TEST(SiteView, LetsRaysGoAsFarAsTheStreetDoes) {
  const CorridorScene scene;
  const SiteView& view = scene.views.front();
  std::size_t count = 0;
  std::size_t near_count = 0;
  for (std::size_t i = 0; i < scene.directions.size(); ++i) {
    const double true_m = expected_m(view.p_map_m, scene.directions[i]);
    if (!(true_m < 30.0)) continue;
    ++count;
    near_count += std::abs(view.distance_m[i] - true_m) < 0.2 ? 1 : 0;
  }
  EXPECT_GT(count, 5000U);
  EXPECT_GT(static_cast<double>(near_count), 0.95 * static_cast<double>(count));
}

}  // namespace
}  // namespace sightline
