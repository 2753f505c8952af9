#include "passes/model/choice/floor.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "passes/model/choose_ranges.h"
#include "tests/support/handmade_model.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// 20 sites, ranges 10 to 40 m: all own scans are within 0.1 m at 20 m and beyond, none at 10 m, but
// for the last site, which needs 40 m.
OwnEvidence one_hard_place() {
  std::vector<std::vector<double>> error_m(20, {0.3, 0.05, 0.04, 0.03});
  error_m.back() = {0.5, 0.3, 0.2, 0.05};
  return *own_evidence_of(factors_with_own_error({10, 20, 30, 40}, error_m));
}

Choice everywhere(std::uint8_t range_index, std::size_t count = 20) {
  return choose_everywhere(range_index, count);
}

TEST(OwnEvidence, TakesTheCheapestStaticAnswerThatCoversEnough) {
  const OwnEvidence evidence = one_hard_place();
  const StaticAnswer answer = best_static(evidence, 0.1, 0.95);
  EXPECT_EQ(answer.range_index, 1);
  EXPECT_NEAR(answer.standing.coverage, 0.95, 1e-12);
  EXPECT_NEAR(answer.standing.cost, 400.0, 1e-9);
  EXPECT_EQ(best_static(evidence, 0.1, 0.96).range_index, 3);
}

TEST(OwnEvidence, TakesWhatCoversMostWhereNothingCoversEnough) {
  const std::vector<std::vector<double>> error_m = {{0.3, 0.05, 0.3}, {0.3, 0.3, 0.3}};
  const OwnEvidence evidence = *own_evidence_of(factors_with_own_error({10, 20, 30}, error_m));
  EXPECT_EQ(best_static(evidence, 0.1, 0.95).range_index, 1) << "not the longest by itself";
  EXPECT_NEAR(best_static(evidence, 0.1, 0.95).standing.coverage, 0.5, 1e-12);
  EXPECT_EQ(best_static(evidence, 0.01, 0.95).range_index, 1) << "nothing helps: the least error";
}

TEST(OwnEvidence, OfOneLocalizerMakesAnotherLookAsFarAsThereIs) {
  const StaticAnswer answer = best_static(for_another_localizer(one_hard_place()), 0.1, 0.95);
  EXPECT_EQ(answer.range_index, 3);
  EXPECT_EQ(answer.standing.coverage, 1.0);
}

TEST(OwnEvidence, IsTheMappingErrorOrTheVirtualOneWhereThereIsNoOther) {
  FactorTable factors = factors_with_own_error({10, 20}, {{0.3, 0.05}});
  for (const char* name : {"mapping_error", "virtual_error"}) {
    factors.factors[0] = name;
    EXPECT_EQ(own_evidence_of(factors)->error_m, (std::vector<double>{0.3, 0.05})) << name;
  }
  factors.factors[0] = "feature_count";
  EXPECT_EQ(own_evidence_of(factors).error().code, ErrorCode::kMismatchedInputs);
}

// A model's p* of 0.99, from one hard place elsewhere, sends all sites as far as there is.
TEST(Floor, AModelNeverMakesAnEasyStreetDear) {
  Choice choice = everywhere(3);
  std::ranges::fill(choice.flags, kUnmet);
  const std::optional<StaticAnswers> taken =
      apply_floor(one_hard_place(), 0.1, {.explained = 0.5}, choice);
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(choice.range_index, everywhere(1).range_index);
  EXPECT_EQ(choice.flags[0], kStatic);
  EXPECT_EQ(choice.flags[19], kStatic | kUnmet) << "its own scan is not within the limit at 20 m";
  EXPECT_EQ(choice.reasons, std::vector<Reason>(20, Reason::kCheaper));
  EXPECT_EQ(
      to_text(*taken, 0.1),
      "No promise: the model's choice takes more time and covers no more sites, so one range is "
      "used for the whole map: 20 m; the measured error is within 0.1 m at 95.0 % of the "
      "sites");
}

// A scan that made the map lies well in it at 10 m, one of the next drive does not.
TEST(Floor, BelievesTheDriveThatWasMeasuredHereBeforeTheMapsOwnScans) {
  const ErrorModel model =
      handmade_model(std::vector<HandmadeSite>(20, {{0.2, 0.9}, {0.4, 0.05}}), 4);
  const Sites sites = sites_of(model);
  OwnEvidence evidence = *own_evidence_of(
      factors_with_own_error({10, 20}, std::vector<std::vector<double>>(20, {0.02, 0.06})));
  EXPECT_EQ(best_static(evidence, 0.1, 0.95).range_index, 0);
  add_measured(sites, model.out_of_fold, model, evidence);
  EXPECT_EQ(evidence.error_m[0], 0.4);
  EXPECT_EQ(evidence.error_m[1], 0.06) << "the larger of the two";
  EXPECT_EQ(best_static(evidence, 0.1, 0.95).range_index, 1);
}

TEST(Floor, BelievesNoDriveOfAnotherPlaceThatBeginsAtZeroToo) {
  const ErrorModel model =
      handmade_model(std::vector<HandmadeSite>(20, {{0.2, 0.9}, {0.4, 0.05}}), 4);
  const Sites sites = sites_of(model);
  const std::vector<std::vector<double>> own_error_m(20, {0.02, 0.06});
  const OwnEvidence before = *own_evidence_of(factors_with_own_error({10, 20}, own_error_m));
  OwnEvidence evidence = before;
  PredictedError elsewhere = model.out_of_fold;
  elsewhere.out_of_fold.assign(20, 0);
  add_measured(sites, elsewhere, model, evidence);
  EXPECT_EQ(evidence.error_m, before.error_m);
  PredictedError of_another_case = model.out_of_fold;
  for (double& mean_m : of_another_case.mean_m) mean_m += 0.01;
  add_measured(sites, of_another_case, model, evidence);
  EXPECT_EQ(evidence.error_m, before.error_m);
}

TEST(Floor, LeavesAChoiceThatIsCheaperOrCoversMoreForItsPrice) {
  const OwnEvidence evidence = one_hard_place();
  Choice cheaper = everywhere(1);
  cheaper.range_index.front() = 0;  // covers 90 % for less than 20 m everywhere
  const Choice before = cheaper;
  EXPECT_FALSE(apply_floor(evidence, 0.1, {.explained = 0.5}, cheaper).has_value());
  EXPECT_EQ(cheaper.range_index, before.range_index);
  Choice adaptive = everywhere(1);
  adaptive.range_index.back() = 3;  // covers all, which no range but 40 m does
  EXPECT_FALSE(
      apply_floor(evidence, 0.1, {.is_promised = true, .explained = 0.5}, adaptive).has_value());
}

TEST(Floor, APromiseIsGivenUpForATenthOrNotAtAll) {
  const OwnEvidence evidence = one_hard_place();
  Choice choice = everywhere(1);
  for (std::size_t site = 0; site < 3; ++site) choice.range_index[site] = 2;
  Choice dearer = everywhere(2);
  const FloorOptions promised{.is_promised = true, .alpha = 0.1, .explained = 0.5};
  EXPECT_FALSE(apply_floor(evidence, 0.1, promised, choice).has_value()) << "7.5 % dearer";
  EXPECT_TRUE(apply_floor(evidence, 0.1, promised, dearer).has_value()) << "50 % dearer";
}

TEST(Floor, APromiseIsGivenUpForWhatIsProvenAsWell) {
  const auto is_given_up = [](double alpha, double block_count) {
    Choice dearest = everywhere(3);
    const FloorOptions promised{.static_coverage = 1.0 - alpha,
                                .is_promised = true,
                                .alpha = alpha,
                                .block_count = block_count,
                                .explained = 0.5};
    return apply_floor(one_hard_place(), 0.1, promised, dearest).has_value();
  };
  // 20 m covers 95 % there.
  EXPECT_TRUE(is_given_up(0.10, 20.0)) << "0.05 + 0.95 / 21 < 0.10";
  EXPECT_FALSE(is_given_up(0.10, 10.0)) << "a short street proves little";
  EXPECT_FALSE(is_given_up(0.05, 1e6)) << "and less where more is promised";
}

TEST(Floor, AModelThatExplainsNothingIsNotAsked) {
  Choice choice = everywhere(0);  // cheaper than anything that covers a site
  std::optional<StaticAnswers> taken =
      apply_floor(one_hard_place(), 0.1, {.explained = -0.2}, choice);
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(choice.reasons[0], Reason::kExplainsNothing);
  EXPECT_EQ(choice.range_index, everywhere(1).range_index);
  const std::string begin =
      "No promise: the model cannot distinguish the places (cross-validated "
      "R^2 -0.20";
  EXPECT_TRUE(to_text(*taken, 0.1).starts_with(begin + "), so one range is used for the whole map"))
      << to_text(*taken, 0.1);
  taken->route_m = 121.0;
  taken->needed_route_m = 1140.0;
  EXPECT_TRUE(
      to_text(*taken, 0.1)
          .starts_with(begin + "; 121 m of route, a promise needs 1.2 km), so one range is used"))
      << to_text(*taken, 0.1);
  Choice of_a_short_drive = everywhere(0);
  const FloorOptions too_short{.explained = 1e-16, .is_too_short = true};
  EXPECT_TRUE(apply_floor(one_hard_place(), 0.1, too_short, of_a_short_drive).has_value())
      << "the last bits of a share decide nothing";
}

TEST(Floor, ExplainedIsWhatTheModelTellsBeyondTheRange) {
  ErrorModel model = handmade_model({{{0.5, 0.5}, {0.30, 0.06}}, {{0.5, 0.5}, {0.20, 0.04}}}, 2);
  model.out_of_fold.mean_m = {0.25, 0.05, 0.25, 0.05};  // the mean of each range
  EXPECT_NEAR(explained_share(model), 0.0, 1e-12);
  model.out_of_fold.mean_m = {0.30, 0.06, 0.20, 0.04};
  EXPECT_NEAR(explained_share(model), 1.0, 1e-12);
  model.out_of_fold.mean_m = {0.20, 0.04, 0.30, 0.06};
  EXPECT_NEAR(explained_share(model), -3.0, 1e-9);
}

TEST(Floor, IsNeverDearerThanTheStaticAnswerOfEqualCoverage) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    std::vector<std::vector<double>> error_m;
    Choice choice;
    for (int site = 0; site < 30; ++site) {
      error_m.push_back({});
      for (int range = 0; range < 4; ++range) error_m.back().push_back(random.uniform(0.0, 0.2));
      choice.range_index.push_back(static_cast<std::uint8_t>(random.below(4)));
      choice.flags.push_back(0);
      choice.reasons.push_back(Reason::kModel);
    }
    const OwnEvidence evidence =
        *own_evidence_of(factors_with_own_error({10, 20, 30, 40}, error_m));
    const FloorOptions options{.static_coverage = random.uniform(0.3, 0.9), .explained = 0.5};
    const Standing before = standing_of(evidence, 0.1, choice.range_index);
    apply_floor(evidence, 0.1, options, choice);
    const Standing after = standing_of(evidence, 0.1, choice.range_index);
    EXPECT_LE(after.cost, before.cost + 1e-9);
    EXPECT_GE(after.coverage + 1e-9, std::min(before.coverage, options.static_coverage));
    const StaticAnswer equal = best_static(evidence, 0.1, after.coverage);
    if (equal.standing.coverage + 1e-9 >= after.coverage) {
      EXPECT_LE(after.cost, equal.standing.cost + 1e-9);
    }
  }
}

ErrorModel five_sites() {
  const HandmadeSite easy = {{0.9, 0.9, 0.9}, {0.05, 0.05, 0.05}};
  return handmade_model(
      {easy, easy, {{0.2, 0.9, 0.9}, {0.15, 0.05, 0.05}}, easy, {{0.1, 0.2, 0.3}, {0.3, 0.3, 0.3}}},
      2);
}

std::vector<double> chosen_m(const RangeTable& table, std::size_t limit) {
  std::vector<double> ranges_m;
  for (std::size_t i = 0; i < table.site_count; ++i) ranges_m.push_back(table.range_m(i, limit));
  return ranges_m;
}

TEST(ChooseRanges, GivesRefusedSitesTheStreetsStaticAnswerUnlessToldOtherwise) {
  const ErrorModel model = five_sites();
  PredictedError predicted = model.out_of_fold;
  predicted.extrapolated[0] = 1;  // its answer is 10 m
  predicted.extrapolated[4] = 1;  // site 1 at 20 m, where its answer is 10 m
  const FactorTable factors =
      factors_with_own_error({10, 20, 30}, std::vector<std::vector<double>>(5, {0.3, 0.05, 0.02}));
  ChooseRangesOptions options{.risk_control = RiskControl::kFixed};
  options.dilation_m = 0.0;
  PassContext ctx;
  const Result<RangeTable> careful =
      of_ranges(choose_ranges(ctx, options, sites_of(model), predicted, model, factors));
  options.extrapolated_takes_static = false;
  const Result<RangeTable> trusting =
      of_ranges(choose_ranges(ctx, options, sites_of(model), predicted, model, factors));
  EXPECT_EQ(chosen_m(*careful, 0), (std::vector<double>{20, 10, 20, 10, 30}))
      << "never 30 by itself";
  EXPECT_EQ(chosen_m(*trusting, 0), (std::vector<double>{10, 10, 20, 10, 30}));
  EXPECT_EQ(careful->flags[0], kExtrapolated | kStatic);
  EXPECT_EQ(careful->reasons[0], Reason::kExtrapolated);
  EXPECT_EQ(trusting->reasons[0], Reason::kModel);
  EXPECT_EQ(careful->flags[2], 0) << "another range is refused, its own is not";
  EXPECT_EQ(trusting->flags[0], kExtrapolated);
}

TEST(Floor, MakesTheChoiceBlindToTheLastBitsOfAThreshold) {
  std::vector<HandmadeSite> sites;
  for (int i = 0; i < 60; ++i) {
    sites.push_back({{0.97, 0.974, 0.99}, {i % 5 == 0 ? 0.12 : 0.06, 0.05, 0.04}});
  }
  std::vector<std::vector<double>> choices;
  for (const double last_bits : {0.0, 2e-3}) {
    std::vector<HandmadeSite> moved = sites;
    for (HandmadeSite& site : moved) site.probability[1] += last_bits;
    const ErrorModel model = handmade_model(moved, 3);
    const FactorTable factors =
        factors_with_own_error(ranges_of(model.out_of_fold.looks),
                               std::vector<std::vector<double>>(60, {0.11, 0.05, 0.04}));
    ChooseRangesOptions options{.risk_control = RiskControl::kFixed};
    options.probability_threshold = 0.975;
    const RangeTable table = value_of(of_ranges(
        choose_ranges(TestContext(), options, sites_of(model), model.out_of_fold, model, factors)));
    ASSERT_TRUE(validate(table).has_value());
    choices.push_back(chosen_m(table, 0));
    EXPECT_FALSE(table.promises[0].is_earned);
  }
  EXPECT_EQ(choices[0], choices[1]);
  EXPECT_EQ(choices[0], std::vector<double>(60, 20.0));
}

}  // namespace
}  // namespace sightline
