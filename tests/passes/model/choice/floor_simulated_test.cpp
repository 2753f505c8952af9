#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "formats/base/random.h"
#include "passes/model/choice/floor.h"
#include "passes/model/choose_ranges.h"
#include "tests/support/handmade_model.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

// What a place takes where simulation alone decides.

namespace sightline {
namespace {

// 20 sites: within 0.1 m at 20 m and beyond, none at 10 m, but for the last, which needs 40 m.
OwnEvidence all_but_one_alike() {
  std::vector<std::vector<double>> error_m(19, {0.3, 0.05, 0.04, 0.03});
  error_m.push_back({0.5, 0.3, 0.2, 0.05});
  return *own_evidence_of(factors_with_own_error({10, 20, 30, 40}, error_m));
}

Choice everywhere(std::uint8_t range_index, std::size_t count = 20) {
  return choose_everywhere(range_index, count);
}

DilatedRoute route_of_metres(std::size_t count, double dilation_m) {
  DilatedRoute dilated{{}, dilation_m};
  for (std::size_t i = 0; i < count; ++i) dilated.route.push_back({0, static_cast<double>(i)});
  return dilated;
}

// Of 20 sites 12 are within 0.1 m at 10 m, 4 more at 20 m, 3 more at 30 m, and one at none.
OwnEvidence four_kinds_of_places() {
  std::vector<std::vector<double>> error_m(12, {0.05, 0.04, 0.03, 0.02});
  error_m.resize(16, {0.3, 0.05, 0.04, 0.03});
  error_m.resize(19, {0.3, 0.2, 0.05, 0.04});
  error_m.resize(20, {0.9, 0.8, 0.7, 0.6});
  OwnEvidence evidence = *own_evidence_of(factors_with_own_error({10, 20, 30, 40}, error_m));
  evidence.is_simulated = true;
  return evidence;
}

TEST(Floor, OfSimulationEachPlaceTakesItsOwnBetweenWhatIsEnoughAtMostPlaces) {
  Choice choice = everywhere(3);
  const StaticAnswers taken =
      take_simulated(four_kinds_of_places(), 0.1, 0.95, route_of_metres(20, 0.0), choice);
  std::vector<std::uint8_t> expected(16, 1);  // 20 m are enough at 80 % and below
  expected.resize(20, 2);                     // 30 m at 95 % and above
  EXPECT_EQ(choice.range_index, expected);
  EXPECT_EQ(choice.flags[0], kStatic);
  EXPECT_EQ(choice.flags[19], kStatic | kUnmet);
  EXPECT_EQ(choice.reasons, std::vector<Reason>(20, Reason::kSimulation));
  EXPECT_EQ(to_text(taken, 0.1),
            "No promise: no drive was recorded here, and no model of other drives was given, so "
            "ranges from 20 m to 30 m are used, by site; twice the simulated error is within 0.1 m "
            "at 95.0 % of the sites");
}

TEST(Floor, OfSimulationAPlaceLooksAsFarAsItsNeighbours) {
  Choice choice = everywhere(0);
  take_simulated(four_kinds_of_places(), 0.1, 0.95, route_of_metres(20, 3.0), choice);
  EXPECT_EQ(choice.range_index[12], 1);
  EXPECT_EQ(choice.range_index[13], 2) << "site 16 is 3 m away";
}

TEST(Floor, OfSimulationIsOneAnswerWherePlacesAreAlikeOrNothingHelps) {
  Choice choice = everywhere(3);
  const std::string alike = to_text(
      take_simulated(all_but_one_alike(), 0.1, 0.95, route_of_metres(20, 3.0), choice), 0.1);
  EXPECT_EQ(choice.range_index, everywhere(1).range_index);
  EXPECT_NE(alike.find("one range is used for the whole map: 20 m; "), std::string::npos) << alike;
  take_simulated(all_but_one_alike(), 0.01, 0.95, route_of_metres(20, 3.0), choice);
  EXPECT_EQ(choice.range_index, everywhere(3).range_index) << "the least error";
  for (const std::uint8_t flags : choice.flags) EXPECT_EQ(flags, kStatic | kUnmet);
}

TEST(Floor, OfSimulationALooserLimitNeverLooksFarther) {
  Random random(5);
  for (int world = 0; world < 50; ++world) {
    std::vector<std::vector<double>> error_m;
    for (int site = 0; site < 30; ++site) {
      std::vector<double> of_site;
      for (int range = 0; range < 4; ++range)
        of_site.push_back(random.uniform(0.0, 0.3 / (range + 1)));
      error_m.push_back(of_site);
    }
    const OwnEvidence evidence =
        *own_evidence_of(factors_with_own_error({10, 20, 30, 40}, error_m));
    Choice tight = everywhere(0, 30);
    Choice loose = everywhere(0, 30);
    take_simulated(evidence, 0.1, 0.95, route_of_metres(30, 0.0), tight);
    take_simulated(evidence, 0.3, 0.95, route_of_metres(30, 0.0), loose);
    const std::uint8_t least = best_static(evidence, 0.1, 0.8).range_index;
    const std::uint8_t most = best_static(evidence, 0.1, 0.95).range_index;
    for (std::size_t site = 0; site < 30; ++site) {
      EXPECT_GE(tight.range_index[site], std::min(least, most));
      EXPECT_LE(tight.range_index[site], std::max(least, most));
      EXPECT_LE(loose.range_index[site], tight.range_index[site]);
    }
  }
}

// 17 sites are within 0.1 m at once, the last three at the second look.
RangeTable chosen_of_simulation(bool takes_samples) {
  std::vector<std::vector<double>> error_m(17, {0.05, 0.04});
  error_m.resize(20, {0.3, 0.05});
  std::vector<HandmadeSite> by_hand;
  for (const std::vector<double>& of_site_m : error_m) by_hand.push_back({{0.5, 0.5}, of_site_m});
  ErrorModel model = handmade_model(by_hand, 1);
  model.card.reference = ErrorReference::kSimulated;
  model.card.fold_count = 0;
  FactorTable factors = factors_with_own_error({10, 20}, error_m);
  if (takes_samples) {
    factors.looks = {{.range_m = 100.0, .return_count = 400, .point_count = 32},
                     {.range_m = 100.0, .return_count = 650, .point_count = 40}};
    model.out_of_fold.looks = factors.looks;
  }
  const ChooseRangesOptions options{.alpha = 0.05};
  return *of_ranges(
      choose_ranges(TestContext(), options, sites_of(model), model.out_of_fold, model, factors));
}

TEST(Floor, OfSimulationRangesDifferByPlaceAndLooksDoNot) {
  const RangeTable ranges = chosen_of_simulation(/*takes_samples=*/false);
  const RangeTable looks = chosen_of_simulation(/*takes_samples=*/true);
  for (std::size_t site = 0; site < 20; ++site) {
    EXPECT_EQ(ranges.range(site, 0), site < 14 ? 0 : 1) << site << ", dilated by 3 m";
    EXPECT_EQ(looks.range(site, 0), 1) << site;
    EXPECT_EQ(ranges.reason(site, 0), Reason::kSimulation);
    EXPECT_EQ(looks.reason(site, 0), Reason::kNoDrive);
  }
  EXPECT_NE(ranges.promises[0].statement.find("from 10 m to 20 m are used, by site"),
            std::string::npos);
  EXPECT_NE(looks.promises[0].statement.find("one look is used for the whole map: 100 m"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline
