#include <gtest/gtest.h>

#include "tests/bench/looks/look_tables.h"
#include "tests/support/value_of.h"

// Figures are only as good as what counts them.

namespace sightline {
namespace {

PlaceFigures place_of(double error_m, double work, double time_ms) {
  return {.error_m = error_m, .work = work, .is_timed = true, .time_ms = time_ms};
}

TEST(OracleOfLooks, TakesTheCheapestByWorkThatIsGoodAndElseTheMostAccurate) {
  const std::vector<MeasuredRule> rules = {{.kind = MeasuredRule::Kind::kReference}, {}, {}, {}};
  // Place 0: both last are good, the third by less work. Place 1: none is. The reference is none.
  const std::vector<RuleFigures> figures = {{place_of(0.01, 1.0, 0.1), place_of(0.01, 1.0, 0.1)},
                                            {place_of(0.30, 5.0, 1.0), place_of(0.30, 5.0, 1.0)},
                                            {place_of(0.09, 6.0, 3.0), place_of(0.20, 6.0, 3.0)},
                                            {place_of(0.02, 9.0, 2.0), place_of(0.40, 9.0, 2.0)}};
  const RuleFigures oracle = oracle_of_looks(rules, figures, 0.1);
  EXPECT_EQ(oracle[0].work, 6.0);
  EXPECT_EQ(oracle[0].time_ms, 3.0);
  EXPECT_EQ(oracle[1].error_m, 0.20);
}

TEST(MeasuredRule, SaysWhatItReadsAndRefusesWhatMakesNoSense) {
  for (const std::string& text : usual_looks()) {
    EXPECT_EQ(to_text(value_of(parse_look_rule(text), text)), text);
  }
  const std::string every = "50 m, 2850 returns, evenly spaced beyond 50 m, one voxel in 4";
  ASSERT_TRUE(parse_look_rule(every));
  EXPECT_EQ(to_text(*parse_look_rule(every)), every);
  EXPECT_FALSE(parse_look_rule("50 m, one voxel in 4"));
  EXPECT_FALSE(parse_look_rule("50 m, 900 returns, 80 points, one voxel in 4"));
  EXPECT_FALSE(parse_look_rule("50 m, 900 returns, one voxel in none"));
}

MappedTown town_with(const HarderDrive& harder) {
  return make_mapped_town({.town = {.seed = 4, .length_m = 20.0}, .harder = harder, .threads = 1});
}

// The map and the way are the same, and what is seen half way is not.
void expect_harder(const HarderDrive& harder, double returns_left) {
  static const MappedTown usual = town_with({});
  const MappedTown town = town_with(harder);
  EXPECT_EQ(town.map.nds.size(), usual.map.nds.size());
  ASSERT_EQ(town.scans.size(), 21U);
  EXPECT_TRUE(town.T_map_vehicle[10].isApprox(usual.T_map_vehicle[10]));
  EXPECT_NE(town.scans[10].points_m, usual.scans[10].points_m);
  EXPECT_NEAR(static_cast<double>(town.scans[10].points_m.size()) /
                  static_cast<double>(usual.scans[10].points_m.size()),
              returns_left, 0.05);
}

TEST(MappedTown, IsRebuiltWhereTheDriveJudges) { expect_harder({.rebuilt_share = 0.5}, 1.0); }
TEST(MappedTown, IsCrowdedWhereTheDriveJudges) { expect_harder({.traffic = 5.0}, 1.0); }
TEST(MappedTown, LacksReturnsWhereTheDriveJudges) { expect_harder({.missing_share = 0.3}, 0.7); }

}  // namespace
}  // namespace sightline
