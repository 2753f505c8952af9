#include "passes/model/choose_ranges.h"

#include <gtest/gtest.h>

#include "tests/passes/model/honest_model.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// Five sites, three ranges: the third site is hard, the last one hopeless.
ErrorModel five_sites() {
  return handmade_model({{{0.9, 0.9, 0.9}, {0.05, 0.05, 0.05}},
                         {{0.9, 0.9, 0.9}, {0.05, 0.05, 0.05}},
                         {{0.2, 0.9, 0.9}, {0.15, 0.05, 0.05}},
                         {{0.9, 0.9, 0.9}, {0.05, 0.05, 0.05}},
                         {{0.1, 0.2, 0.3}, {0.3, 0.3, 0.3}}},
                        2);
}

std::vector<double> chosen_m(const RangeTable& table, std::size_t limit) {
  std::vector<double> ranges_m;
  for (std::size_t i = 0; i < table.site_count; ++i) ranges_m.push_back(table.range_m(i, limit));
  return ranges_m;
}

std::vector<Reason> reasons_of(const RangeTable& table, std::size_t limit) {
  std::vector<Reason> reasons;
  for (std::size_t i = 0; i < table.site_count; ++i) reasons.push_back(table.reason(i, limit));
  return reasons;
}

TEST(ChooseRanges, TakesTheShortestProbableRangeAndDilates) {
  ChooseRangesOptions options = with(RiskControl::kFixed);
  options.dilation_m = 1.0;
  const RangeTable table = value_of(choose(five_sites(), options));
  ASSERT_TRUE(validate(table).has_value());
  EXPECT_EQ(chosen_m(table, 0), (std::vector<double>{10, 20, 20, 30, 30}));
  EXPECT_EQ(table.flags[3 * 2], 0);
  EXPECT_EQ(table.flags[4 * 2], kUnmet);
  EXPECT_EQ(reasons_of(table, 0),
            (std::vector<Reason>{Reason::kModel, Reason::kDilation, Reason::kModel,
                                 Reason::kDilation, Reason::kMostProbable}));
  EXPECT_EQ(table.promises[0].method, "fixed");
  EXPECT_EQ(table.promises[0].calibration_miss_share, 0.0) << "the hopeless site is not answered";
  EXPECT_NEAR(table.promises[0].answered_share, 0.8, 1e-12);
}

TEST(ChooseRanges, ByMeanDoesAsThePaperDoes) {
  const ChooseRangesOptions options{.selection = Selection::kMean};
  const RangeTable table = value_of(choose(five_sites(), options));
  EXPECT_EQ(chosen_m(table, 0), (std::vector<double>{10, 10, 20, 10, 30}));
  EXPECT_EQ(chosen_m(table, 1), (std::vector<double>{10, 10, 10, 10, 10}));
  EXPECT_EQ(table.flags[4 * 2], kUnmet);
  EXPECT_EQ(table.reason(2, 0), Reason::kModel);
  EXPECT_EQ(table.reason(4, 0), Reason::kMostProbable);
  EXPECT_EQ(table.dilation_m, 0.0);
  EXPECT_EQ(table.selection, Selection::kMean);
  EXPECT_FALSE(table.promises[0].is_earned);
}

TEST(ChooseRanges, FallsBackToTheMostProbableRangeAndSaysSo) {
  TestContext ctx;
  const ErrorModel model = five_sites();
  ASSERT_TRUE(of_ranges(choose_ranges(ctx, with(RiskControl::kFixed), sites_of(model),
                                      model.out_of_fold, model, demanding_factors(model)))
                  .has_value());
  ASSERT_EQ(ctx.warnings.size(), 2u);
  EXPECT_EQ(ctx.warnings[0],
            "no range keeps the error within 0.1 m at 1 of 5 sites: they take the most probable "
            "range and are flagged 'unmet'");
}

TEST(ChooseRanges, NeverPromisesWhatTooFewBlocksCannotEarn) {
  for (const RiskControl risk_control : {RiskControl::kConformal, RiskControl::kLearnThenTest}) {
    const RangeTable table = value_of(choose(honest_model(1, 18), with(risk_control)));
    EXPECT_FALSE(table.promises[0].is_earned);
    EXPECT_LE(table.promises[0].calibration_miss_share, 0.05);
    EXPECT_NE(table.promises[0].statement.find("No promise yet: it needs "), std::string::npos)
        << table.promises[0].statement;
  }
  EXPECT_NE(choose(honest_model(1, 18), with(RiskControl::kConformal))
                ->promises[0]
                .statement.find("it needs 1.2 km of measured route; so far there are 1.0 km from 2 "
                                "drives"),
            std::string::npos);
}

TEST(ChooseRanges, PromisesNothingElsewhereFromOnePlaceAlone) {
  ErrorModel model = honest_model(1, 60);
  ASSERT_TRUE(choose(model, with(RiskControl::kConformal))->promises[0].is_earned)
      << "its own sites";
  PredictedError elsewhere = model.out_of_fold;
  std::ranges::fill(elsewhere.out_of_fold, std::uint8_t{0});
  const auto promise_of = [&] {
    return choose(model, with(RiskControl::kConformal), elsewhere)->promises[0];
  };
  EXPECT_FALSE(promise_of().is_earned);
  EXPECT_NE(promise_of().statement.find("trained on one place, and these"), std::string::npos);
  model.card.places.push_back(model.card.places[0]);
  for (std::size_t i = 30 * 60; i < model.sites.size(); ++i) model.sites[i].place = 1;
  EXPECT_FALSE(promise_of().is_earned) << "the same recordings: it is the same place";
  for (RecordingCard& card : model.card.places[1].recordings.cards) {
    card.digest = sha256("elsewhere, " + card.name);
  }
  EXPECT_TRUE(promise_of().is_earned);
  model.card.reference = ErrorReference::kFullRangeMatch;
  EXPECT_FALSE(promise_of().is_earned) << "a match to the map is no truth";
  EXPECT_NE(promise_of().statement.find("matches to the map itself"), std::string::npos)
      << promise_of().statement;
}

TEST(ChooseRanges, PromisesNothingWhereMostSitesAreUnlikeTheTraining) {
  const ErrorModel model = honest_model(1, 60);
  PredictedError predicted = model.out_of_fold;
  const auto promise_of = [&](std::size_t unlike_count) {
    std::ranges::fill(predicted.extrapolated, std::uint8_t{0});
    std::fill_n(predicted.extrapolated.begin(), 5 * unlike_count, std::uint8_t{1});
    return choose(model, with(RiskControl::kConformal), predicted)->promises[0];
  };
  EXPECT_TRUE(promise_of(1800).is_earned);
  EXPECT_FALSE(promise_of(1801).is_earned);
  EXPECT_NE(promise_of(1801).statement.find("1801 of 3600 sites are unlike"), std::string::npos);
}

FactorTable simulated_factors(const ErrorModel& model) {
  const FactorTable measured = demanding_factors(model);
  FactorTable table = measured;
  table.factors.emplace_back(kSimulatedColumn);
  table.values.clear();
  const std::size_t columns = measured.factors.size();
  for (std::size_t i = 0; i < measured.values.size(); ++i) {
    table.values.push_back(measured.values[i]);
    if (i % columns == columns - 1) table.values.push_back(1.0);
  }
  return table;
}

TEST(ChooseRanges, SaysSimulatedWhereNoScanWasEverSeen) {
  ErrorModel model = honest_model(1, 60);
  PredictedError predicted = model.out_of_fold;
  std::ranges::fill(predicted.out_of_fold, std::uint8_t{0});
  predicted.out_of_fold[0] = 1;  // a drive was measured here
  const ChooseRangesOptions options = with(RiskControl::kConformal);
  const auto chosen = [&] {
    return *of_ranges(choose_ranges(TestContext(), options, sites_of(model), predicted, model,
                                    simulated_factors(model)));
  };
  const RangeTable table = chosen();
  ASSERT_TRUE(validate(table).has_value());
  EXPECT_EQ(simulated_site_count(table), table.site_count - 1);
  EXPECT_EQ(table.flags_of(0, 0) & kSimulatedAnswer, 0);
  EXPECT_NE(table.flags_of(1, 0) & kSimulatedAnswer, 0);
  model.card.reference = ErrorReference::kSimulated;
  EXPECT_EQ(simulated_site_count(chosen()), table.site_count);
  EXPECT_FALSE(chosen().promises[0].is_earned);
  EXPECT_EQ(simulated_site_count(*choose(model, options)), 0U) << "scans made that map";
}

TEST(ChooseRanges, PromisesNothingOfSimulatedPlacesByAModelThatNeverSawSuch) {
  ErrorModel model = honest_model(1, 60);
  const ChooseRangesOptions options = with(RiskControl::kConformal);
  ASSERT_TRUE(choose(model, options)->promises[0].is_earned);
  const auto promise = [&] {
    return of_ranges(choose_ranges(TestContext(), options, sites_of(model), model.out_of_fold,
                                   model, simulated_factors(model)))
        ->promises[0];
  };
  EXPECT_FALSE(promise().is_earned);
  EXPECT_NE(promise().statement.find("this map was made without scans"), std::string::npos)
      << promise().statement;
  model.features.front().name = std::string(kSimulatedColumn);
  EXPECT_TRUE(promise().is_earned);
}

TEST(ChooseRanges, PromisesNothingWhereNoRangeReachesTheLimitAnywhere) {
  ErrorModel model = honest_model(1, 60);
  for (double& error_m : model.measured_mean_m) error_m += 0.1;
  for (double& mean_m : model.out_of_fold.mean_m) mean_m += 0.1;
  const RangeTable table = value_of(choose(model, with(RiskControl::kConformal)));
  EXPECT_FALSE(table.promises[0].is_earned);
  EXPECT_NE(table.promises[0].statement.find("no range reached 0.1 m anywhere; the least"),
            std::string::npos)
      << table.promises[0].statement;
}

TEST(ChooseRanges, SaysWhatAModelPromisesBeforeThereIsAMap) {
  const std::vector<std::string> enough =
      promises_of(with(RiskControl::kConformal), honest_model(1, 60));
  ASSERT_EQ(enough.size(), 2u) << "a limit each";
  EXPECT_NE(enough[0].find("On the next drive at most 5 % of this place's answered sites"),
            std::string::npos)
      << enough[0];
  const std::vector<std::string> too_few =
      promises_of(with(RiskControl::kConformal), honest_model(1, 18));
  EXPECT_NE(too_few[0].find("it needs 1.2 km of measured route"), std::string::npos) << too_few[0];
}

TEST(ChooseRanges, NeverPromisesFromBlocksThatSeeTheSameWalls) {
  ErrorModel model = honest_model(1, 60);
  EXPECT_TRUE(choose(model, with(RiskControl::kConformal))->promises[0].is_earned);
  model.card.block_m = 20.0;
  const Result<RangeTable> table = choose(model, with(RiskControl::kConformal));
  EXPECT_FALSE(table->promises[0].is_earned);
  EXPECT_NE(table->promises[0].statement.find("see the same walls"), std::string::npos);
}

TEST(ChooseRanges, KeepsMissesWithinWhatItCalibrated) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const ErrorModel model = honest_model(seed, 48);
    for (const RiskControl risk_control :
         {RiskControl::kConformal, RiskControl::kLearnThenTest, RiskControl::kEmpirical}) {
      const RangeTable table = value_of(choose(model, with(risk_control)));
      for (std::size_t limit = 0; limit < 2; ++limit) {
        double missed = 0.0;
        double answered = 0.0;
        for (std::size_t site = 0; site < table.site_count; ++site) {
          const double error_m = model.measured(site, table.range_index[site * 2 + limit]);
          if ((table.flags_of(site, limit) & kUnmet) != 0) continue;
          answered += 1.0;
          missed += error_m > model.out_of_fold.limits_m[limit] ? 1.0 : 0.0;
        }
        const double share = missed / answered;
        EXPECT_NEAR(answered / table.site_count, table.promises[limit].answered_share, 1e-9);
        EXPECT_NEAR(share, table.promises[limit].calibration_miss_share, 1e-9);
        EXPECT_LE(share, 0.05);
      }
    }
  }
}

// Of the tightest limit; a looser one may trade what the tighter no longer asks for.
TEST(ChooseRanges, ALargerAlphaNeverLooksFurther) {
  const ErrorModel model = honest_model(3, 48);
  for (const RiskControl risk_control :
       {RiskControl::kConformal, RiskControl::kLearnThenTest, RiskControl::kEmpirical}) {
    std::vector<double> before_m(model.sites.size(), 50.0);
    for (const double alpha : {0.1, 0.2, 0.4}) {
      const RangeTable table = value_of(choose(model, with(risk_control, alpha)));
      EXPECT_EQ(table.promises[0].is_earned, risk_control != RiskControl::kEmpirical);
      const std::vector<double> now_m = chosen_m(table, 0);
      for (std::size_t i = 0; i < now_m.size(); ++i) EXPECT_LE(now_m[i], before_m[i]);
      before_m = now_m;
    }
  }
}

TEST(ChooseRanges, ALooserLimitNeverLooksFurther) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const RiskControl risk_control :
         {RiskControl::kConformal, RiskControl::kEmpirical, RiskControl::kFixed}) {
      const RangeTable table = value_of(choose(honest_model(seed, 20), with(risk_control)));
      for (std::size_t i = 0; i < table.site_count; ++i) {
        EXPECT_LE(table.range_m(i, 1), table.range_m(i, 0));
      }
    }
  }
}

TEST(ChooseRanges, JudgesSitesWithHistoryByAThresholdOfTheirOwn) {
  // The even cases know an earlier drive and are always right at 0.75; the others at 0.9.
  std::vector<HandmadeSite> sites;
  for (std::size_t i = 0; i < 400; ++i) {
    const bool is_told = i >= 200;
    const double doubtful = is_told ? 0.72 : 0.85;
    const double sure = is_told ? 0.78 : 0.95;
    const double more_m = i % 2 == 0 ? 0.0 : 0.02;
    sites.push_back({{doubtful, sure}, {0.2 + more_m, 0.05 + more_m}});
  }
  ErrorModel model = handmade_model(sites, 4);
  model.card.knows_history = true;
  model.out_of_fold.mean_m = model.measured_mean_m;  // it explains what it is to explain
  for (std::size_t i = 200; i < 400; ++i) {
    model.sites[i].has_history = 1;
    model.out_of_fold.has_history[i] = 1;
    model.sites[i].run = 1;
  }
  const RangeTable table = value_of(choose(model, with(RiskControl::kEmpirical)));
  const LimitPromise& promise = table.promises[0];
  EXPECT_GT(promise.probability_threshold, 0.85);
  EXPECT_LE(promise.probability_threshold, 0.95);
  EXPECT_GT(promise.history_threshold, 0.72);
  EXPECT_LE(promise.history_threshold, 0.78);
  EXPECT_EQ(chosen_m(table, 0), std::vector<double>(400, 20.0));
  EXPECT_EQ(promise.block_count, 2u);
  EXPECT_NE(promise.statement.find("; places without: "), std::string::npos);
}

TEST(ChooseRanges, RefusesHistoryThatTheModelKnowsNothingOf) {
  const ErrorModel model = five_sites();
  PredictedError with_history = model.out_of_fold;
  with_history.has_history[2] = 1;
  EXPECT_EQ(failure_of(choose(model, {}, with_history)).code, ErrorCode::kMismatchedInputs);
}

TEST(ChooseRanges, RefusesInputsThatDoNotBelongTogether) {
  const ErrorModel model = five_sites();
  PassContext ctx;
  Sites fewer = sites_of(model);
  fewer.sites.pop_back();
  const FactorTable factors = demanding_factors(model);
  EXPECT_EQ(choose_ranges(ctx, {}, fewer, model.out_of_fold, model, factors).error().code,
            ErrorCode::kMismatchedInputs);
  FactorTable without = factors;
  without.factors[0] = "feature_count";
  FactorTable shorter = factors;
  shorter.looks.back().range_m = 25.0;
  for (const FactorTable& unfit : {without, shorter}) {
    EXPECT_EQ(choose_ranges(ctx, {}, sites_of(model), model.out_of_fold, model, unfit).error().code,
              ErrorCode::kMismatchedInputs);
  }
  PredictedError other = model.out_of_fold;
  other.limits_m[1] = 0.3;
  EXPECT_EQ(choose_ranges(ctx, {}, sites_of(model), other, model, factors).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
