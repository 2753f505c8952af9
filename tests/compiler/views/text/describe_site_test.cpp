#include "compiler/views/text/describe_site.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/reader/site_errors.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

// Ten sites, a metre apart, that all look 10 m for 0.1 m, but site 4, which needs 20 m, and its
// neighbours within 1 m.
CompiledMap short_route() {
  CompiledMap map;
  map.sites.sites.resize(10);
  map.ranges.looks = map.predicted.looks = map.factors.looks = every_return_at({10.0, 20.0});
  map.ranges.dilation_m = 1.0;
  map.ranges.site_count = map.predicted.site_count = map.factors.site_count = 10;
  map.ranges.promises.resize(1);
  map.ranges.promises[0].limit_m = 0.1;
  map.ranges.promises[0].probability_threshold = 0.8;
  map.predicted.limits_m = {0.1};
  map.predicted.has_history.assign(10, 0);
  map.factors.factors = {"feature_count", "crlb_max", "crlb_min", "crlb_heading"};
  for (std::size_t i = 0; i < 10; ++i) {
    const bool is_hard = i == 4;
    const bool is_near = i >= 3 && i <= 5;
    map.sites.sites[i].s_m = static_cast<double>(i);
    map.sites.sites[i].p_map_m.x() = static_cast<double>(i);
    map.predicted.mean_m.insert(map.predicted.mean_m.end(), {is_hard ? 0.3 : 0.05, 0.04});
    map.predicted.within_probability.insert(map.predicted.within_probability.end(),
                                            {is_hard ? 0.5 : 0.9, 0.95});
    map.ranges.range_index.push_back(is_near ? 1 : 0);
    map.ranges.flags.push_back(0);
    map.ranges.reasons.push_back(is_near && !is_hard ? Reason::kDilation : Reason::kModel);
    const double count = 100.0 + static_cast<double>(i % 3);
    for (int range = 0; range < 2; ++range) {
      const double weak_m = is_hard ? 0.4 : 0.020 + 0.001 * static_cast<double>(i % 4);
      map.factors.values.insert(map.factors.values.end(), {count, weak_m, 0.01, 5.0});
    }
  }
  return map;
}

TEST(DescribeSite, SaysWhichRangeMeetsThePromiseAndWhichFactorsAreFarOff) {
  const std::string text = value_of(describe_site(short_route(), 4));
  EXPECT_THAT(text, HasSubstr("within 0.1 m: range 20 m"));
  EXPECT_THAT(text, HasSubstr("shortest range with p* = 0.800: 20 m"));
  EXPECT_THAT(text, HasSubstr("nearest site with a shorter range: 2, 2.0 m back, 10 m"));
  EXPECT_THAT(text, HasSubstr("crlb_max"));
  EXPECT_THAT(text, Not(HasSubstr("feature_count")));
  EXPECT_THAT(text, HasSubstr("weakest along the road: 5 degrees from +x, 5 off the road"));
  EXPECT_THAT(text, HasSubstr("40.0 times"));
}

TEST(DescribeSite, NamesTheNeighbourThatAsksForMore) {
  EXPECT_THAT(*describe_site(short_route(), 3), HasSubstr("longer because of site 4, 1.0 m away"));
  EXPECT_THAT(*describe_site(short_route(), 3), HasSubstr("    reason: dilation\n"));
  EXPECT_THAT(*describe_site(short_route(), 0), Not(HasSubstr("longer")));
}

TEST(DescribeSite, SaysThatATighterLimitNeedsNoMore) {
  CompiledMap map = short_route();
  map.ranges.range_index[4] = 0;  // its own predictions ask for 20 m
  map.ranges.reasons[4] = Reason::kTighterLimit;
  const std::string text = value_of(describe_site(map, 4));
  EXPECT_THAT(text, HasSubstr("    shorter: it is enough for the next tighter limit\n"));
  EXPECT_THAT(text, Not(HasSubstr("longer")));
}

TEST(DescribeSite, SaysWhichStaticAnswerItIs) {
  CompiledMap map = short_route();
  map.ranges.flags[4] = kStatic;
  const auto text_for = [&](Reason reason) {
    map.ranges.reasons[4] = reason;
    return value_of(describe_site(map, 4));
  };
  EXPECT_THAT(text_for(Reason::kSimulation), HasSubstr("static: from the simulation at this"));
  EXPECT_THAT(text_for(Reason::kDrives),
              HasSubstr("each drive predicted by the others, not from the model"));
  EXPECT_THAT(text_for(Reason::kCheaper), HasSubstr("static: one range for the street"));
}

TEST(DescribeSite, SaysSoWhereNoRangeIsGoodEnough) {
  CompiledMap map = short_route();
  map.predicted.within_probability[9] = 0.6;  // site 4 at 20 m
  map.ranges.flags[4] = kUnmet | kExtrapolated;
  const std::string text = *describe_site(map, 4);
  EXPECT_THAT(text, HasSubstr("no range has p* = 0.800"));
  EXPECT_THAT(text, HasSubstr("unmet"));
  EXPECT_THAT(text, HasSubstr("extrapolated"));
}

TEST(DescribeSite, AsksASiteWithHistoryForItsOwnProbability) {
  CompiledMap map = short_route();
  map.ranges.promises[0].history_threshold = 0.5;
  map.predicted.has_history[4] = 1;
  EXPECT_THAT(*describe_site(map, 4), HasSubstr("shortest range with p* = 0.500: 10 m"));
  EXPECT_THAT(*describe_site(map, 6), HasSubstr("shortest range with p* = 0.800: 10 m"));
}

TEST(DescribeSite, ExplainsAnyMapWithAndWithoutFactors) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CompiledMap map = random_map({.seed = seed});
    for (std::size_t site = 0; site < map.sites.sites.size(); site += 3) {
      EXPECT_TRUE(describe_site(map, site).has_value());
    }
    map.factors = {};
    EXPECT_THAT(*describe_site(map, 0), HasSubstr("has no factors"));
  }
}

TEST(DescribeSite, ListsTheColumnsOfTheMap) {
  CompiledMap map = random_map({.seed = 2, .has_columns = true});
  map.columns[0].values[7] = 3.5F;
  map.columns[1].values[7] = 2.0F;
  EXPECT_THAT(*describe_site(map, 7), HasSubstr("  clearance_m 3.5 m\n  kind 2\n"));
}

TEST(DescribeSite, BoundsTheErrorsOfAVehicleThatTracks) {
  CompiledMap map = short_route();
  EXPECT_THAT(value_of(describe_site(map, 3)), HasSubstr("risk 1 % in 60 m: forward "));
  map.columns = {{std::string(kTrackingRangeColumns[1]), "m", std::vector<float>(10, 1000.0F), {}}};
  EXPECT_THAT(value_of(describe_site(map, 3)), ContainsRegex("left [0-9]{4,5}[.][0-9]{2}, up"));
}

TEST(DescribeSite, RefusesASiteThatIsNotThere) {
  EXPECT_EQ(describe_site(short_route(), 10).error().code, ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline
