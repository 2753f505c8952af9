#include "passes/map/places/choose_field_sites.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "formats/base/random.h"
#include "passes/map/places/free_ground.h"
#include "tests/passes/map/places/level_street.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// An upright patch of 0.5 m.
void add_wall(double x_m, double y_m, double middle_m, Surface& surface) {
  SurfacePatch patch;
  patch.centre_m = {x_m, y_m, middle_m};
  patch.key = cell_key(patch.centre_m, 0.5);
  patch.normal = Eigen::Vector3d::UnitX();
  patch.half_side_m = 0.25;
  surface.patches.push_back(patch);
}

Surface divided_street() {
  Surface surface = level_street();
  for (double y_m = -4.75; y_m < 5.0; y_m += 0.5) add_wall(20.0, y_m, 1.0, surface);
  return surface;
}

Result<Sites> choose(TestContext& ctx, const Surface& surface,
                     const ChooseFieldSitesOptions& options, double view_deg = 360.0) {
  SensorProfile sensor = sensor_ahead();
  sensor.azimuth_view_deg = view_deg;
  return choose_field_sites(ctx, options, surface, sensor);
}

ChosenSites chosen(const Surface& surface, const ChooseFieldSitesOptions& options = {},
                   int threads = 1, double view_deg = 360.0) {
  TestContext ctx(threads);
  return {value_of(choose(ctx, surface, options, view_deg)), std::move(ctx.warnings)};
}

std::set<std::pair<double, double>> places_of(const ChosenSites& made) {
  std::set<std::pair<double, double>> places;
  EXPECT_TRUE(validate(made.sites).has_value());
  for (const Site& site : made.sites.sites) {
    const Eigen::Vector3d at_m = site.T_map_vehicle.translation();
    EXPECT_TRUE(places.emplace(at_m.x(), at_m.y()).second) << "a place has one site";
  }
  const std::vector<Site>& sites = made.sites.sites;
  for (std::size_t i = 1; i < sites.size(); ++i) {
    if (sites[i].run != sites[i - 1].run) continue;
    const Eigen::Vector3d step_m =
        sites[i].T_map_vehicle.translation() - sites[i - 1].T_map_vehicle.translation();
    EXPECT_EQ(step_m.head<2>(), Eigen::Vector2d(2.0, 0.0)) << "a run has no gap";
  }
  return places;
}

Error refusal(const Surface& surface, const ChooseFieldSitesOptions& options = {}) {
  TestContext ctx;
  return failure_of(choose(ctx, surface, options));
}

TEST(ChooseFieldSites, StandEveryTwoMetresAMetreOffTheEdgeAndLookAlongTheStreet) {
  const ChosenSites made = chosen(level_street());
  std::set<std::pair<double, double>> expected;
  for (int i = 0; i < 24; ++i) {
    for (const double y_m : {-3.0, -1.0, 1.0, 3.0}) expected.emplace(1.0 + 2.0 * i, y_m);
  }
  EXPECT_EQ(places_of(made), expected);
  const Site& site = made.sites.sites[25];
  EXPECT_EQ(site.run, 1U);
  EXPECT_EQ(site.s_m, 2.0);
  EXPECT_LT((site.T_map_vehicle.translation() - Eigen::Vector3d(3.0, -1.0, 0.1)).norm(), 1e-12);
  EXPECT_LT((site.p_map_m - Eigen::Vector3d(3.5, -1.0, 1.9)).norm(), 1e-12);
  EXPECT_EQ(made.sites.spacing_m, 2.0);
  ASSERT_EQ(made.warnings.size(), 1U);
  EXPECT_NE(made.warnings[0].find("96 places"), std::string::npos) << made.warnings[0];
}

TEST(ChooseFieldSites, LookAcrossWhereTheStreetRunsAcross) {
  Surface across;
  across.frame = level_street().frame;
  across.cell_m = 0.5;
  across.tile_m = 64.0;
  add_floor(box(0.0, 0.0, 6.0, 50.0), 0.0, across);
  const ChosenSites made = chosen(across);
  for (const Site& site : made.sites.sites) {
    EXPECT_NEAR(site.T_map_vehicle.linear()(1, 0), 1.0, 1e-12);
  }
}

TEST(ChooseFieldSites, AreThoseOfTheLargestStretchUnlessAPlaceIsNamed) {
  const Surface surface = divided_street();
  const ChosenSites larger = chosen(surface);
  for (const auto& [x_m, y_m] : places_of(larger)) EXPECT_GT(x_m, 20.9);
  EXPECT_EQ(larger.sites.sites.size(), 13U * 4U);
  EXPECT_NE(larger.warnings[1].find("1 separate area is left out"), std::string::npos)
      << larger.warnings[1];
  ChooseFieldSitesOptions options;
  options.from = "645, 0";
  const std::set<std::pair<double, double>> smaller = places_of(chosen(surface, options));
  EXPECT_EQ(smaller.size(), 9U * 4U);
  for (const auto& [x_m, y_m] : smaller) EXPECT_LT(x_m, 19.1);
}

TEST(ChooseFieldSites, APartOfTheMapIsTakenWithinABox) {
  ChooseFieldSitesOptions options;
  options.within = "650, -2, 660, 2";
  const std::set<std::pair<double, double>> places = places_of(chosen(level_street(), options));
  EXPECT_EQ(places.size(), 5U * 2U);
  for (const auto& [x_m, y_m] : places) {
    EXPECT_TRUE(x_m >= 10.0 && x_m <= 20.0 && std::abs(y_m) <= 2.0);
  }
}

TEST(ChooseFieldSites, AVehiclePassesUnderWhatIsHigherThanItAndOverKerbsAlone) {
  const std::size_t all = places_of(chosen(level_street())).size();
  const std::vector<std::pair<double, bool>> slabs = {
      {0.3, true}, {1.2, false}, {2.0, false}, {2.4, true}, {3.5, true}};
  for (const auto& [height_m, is_free] : slabs) {
    Surface under = level_street();
    add_floor(box(20.0, -5.0, 24.0, 5.0), height_m, under);
    const std::set<std::pair<double, double>> places = places_of(chosen(under));
    if (is_free) {
      EXPECT_EQ(places.size(), all) << height_m;
    } else {
      for (const auto& [x_m, y_m] : places) EXPECT_GT(x_m, 24.9) << height_m;
    }
  }
}

TEST(ChooseFieldSites, AStepThatNoWheelTakesDividesTheStreet) {
  for (const auto& [rise_m, is_one] :
       std::vector<std::pair<double, bool>>{{0.25, true}, {1.0, false}}) {
    Surface surface = level_street();
    for (SurfacePatch& patch : surface.patches) {
      if (patch.centre_m.x() > 20.0) patch.centre_m.z() += rise_m;
    }
    const std::set<std::pair<double, double>> places = places_of(chosen(surface));
    EXPECT_EQ(places.contains({5.0, 1.0}), is_one);
    EXPECT_EQ(places.contains({19.0, 1.0}), is_one);
    EXPECT_TRUE(places.contains({25.0, 1.0}));
  }
}

// Unseen ground is added around all that was seen (ground_gaps.h), behind walls too.
TEST(ChooseFieldSites, NobodyDrivesFarOverGroundThatWasNotSeen) {
  Surface surface = level_street();
  for (double x_m = 0.5; x_m < 80.0; x_m += 1.0) {
    for (double y_m = -4.5; y_m < 15.0; y_m += 1.0) {
      if (x_m < 50.0 && y_m < 5.0) continue;
      SurfacePatch patch;
      patch.centre_m = {x_m, y_m, 0.1};
      patch.key = cell_key(patch.centre_m, 0.5);
      patch.half_side_m = surface.cell_m;
      surface.patches.push_back(patch);
    }
  }
  // Along the street, as far as it was seen.
  for (double x_m = 0.25; x_m < 50.0; x_m += 0.5) {
    add_wall(x_m, 5.0, 1.0, surface);
    surface.patches.back().normal = Eigen::Vector3d::UnitY();
  }
  const std::set<std::pair<double, double>> places = places_of(chosen(surface));
  EXPECT_TRUE(places.contains({51.0, 1.0}));
  for (const auto& [x_m, y_m] : places) {
    EXPECT_LE(x_m, 52.6);
    EXPECT_LE(y_m, 7.0);
    if (x_m < 49.0) {
      EXPECT_LE(y_m, 3.0) << x_m;
    }
  }
}

TEST(ChooseFieldSites, AFloorAboveIsReachedOverARampAlone) {
  Surface bridge = level_street();
  add_floor(box(10.0, -5.0, 20.0, 5.0), 6.1, bridge);
  EXPECT_EQ(places_of(chosen(bridge)).size(), 96U);
  Surface ramp = level_street();
  for (int i = 0; i < 120; ++i) {  // from the street's end on, rising by 0.2
    add_floor(box(50.0 + 0.5 * i, -5.0, 50.5 + 0.5 * i, 5.0), 0.1 + 0.1 * i, ramp);
  }
  const ChosenSites made = chosen(ramp);
  double highest_m = 0.0;
  for (const Site& site : made.sites.sites) {
    highest_m = std::max(highest_m, site.T_map_vehicle.translation().z());
  }
  EXPECT_GT(highest_m, 11.0);
}

// By asking every solid square of posts set at random: what is nearer than a vehicle's half width
// less a raster step is never a place; what is farther from all than that and a step more is one.
TEST(ChooseFieldSites, PostsAreAvoidedAndNothingElseIs) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    Surface surface = level_street();
    std::vector<Eigen::Vector2d> posts;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector2d post(random.uniform(2.0, 48.0), random.uniform(-5.0, 5.0));
      posts.push_back(post);
      add_wall(post.x(), post.y(), 1.0, surface);
      surface.patches.back().half_side_m = 0.05;
    }
    const std::set<std::pair<double, double>> places = places_of(chosen(surface));
    for (int i = 0; i < 24; ++i) {
      for (const double y_m : {-3.0, -1.0, 1.0, 3.0}) {
        double nearest_m = 100.0;
        for (const Eigen::Vector2d& post : posts) {
          nearest_m = std::min(nearest_m, (post - Eigen::Vector2d(1.0 + 2.0 * i, y_m)).norm());
        }
        const bool is_place = places.contains({1.0 + 2.0 * i, y_m});
        if (nearest_m > 0.55 && nearest_m < 1.45) continue;
        EXPECT_EQ(is_place, nearest_m > 1.0) << seed << ": " << 1 + 2 * i << ", " << y_m;
      }
    }
  }
}

TEST(ChooseFieldSites, AreTheSameForAnyOrderOfPatchesAndNumberOfThreads) {
  Surface surface = divided_street();
  add_floor(box(30.0, -5.0, 40.0, 5.0), 6.1, surface);
  const ChosenSites one = chosen(surface);
  std::ranges::reverse(surface.patches);
  EXPECT_EQ(to_bytes(one.sites), to_bytes(chosen(surface, {}, /*threads=*/4).sites));
}

TEST(ChooseFieldSites, RefusesWhatNobodyCouldAnnotate) {
  Surface walls = level_street();
  for (SurfacePatch& patch : walls.patches) patch.normal = Eigen::Vector3d::UnitX();
  EXPECT_EQ(refusal(walls).code, ErrorCode::kNoGround);
  ChooseFieldSitesOptions options;
  options.from = "1000, 0";
  EXPECT_EQ(refusal(level_street(), options).code, ErrorCode::kNoGround);
  options.from = "640; 0";
  EXPECT_EQ(refusal(level_street(), options).code, ErrorCode::kBadValue);
  options = {};
  options.within = "660, -2, 650, 2";
  EXPECT_EQ(refusal(level_street(), options).code, ErrorCode::kBadValue);
  options.within = "1660, -2, 1670, 2";
  EXPECT_EQ(refusal(level_street(), options).code, ErrorCode::kNoGround);
  options = {};
  options.most_places = 95;
  const Error many = refusal(level_street(), options);
  EXPECT_EQ(many.code, ErrorCode::kTooManyPlaces);
  EXPECT_NE(many.message.find("96 places"), std::string::npos) << many.message;
}

TEST(ChooseFieldSites, SayThatAPlaceIsOfOneHeadingToASensorThatDoesNotSeeAllRound) {
  const ChosenSites made = chosen(level_street(), {}, 1, 70.4);
  ASSERT_EQ(made.warnings.size(), 2U);
  EXPECT_NE(made.warnings[1].find("has a view of 70.4 degrees"), std::string::npos);
}

}  // namespace
}  // namespace sightline
