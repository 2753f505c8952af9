#include "passes/model/choose_ranges.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/handmade_model.h"

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

// A long route whose predictions are honest: a site with P misses with probability 1 - P.
ErrorModel honest_model(std::uint64_t seed, std::size_t block_count) {
  Random random(seed);
  std::vector<HandmadeSite> sites;
  double ease = 0.5;
  for (std::size_t i = 0; i < 60 * block_count; ++i) {
    ease = std::clamp(ease + random.uniform(-0.1, 0.1), 0.0, 1.0);
    HandmadeSite site;
    for (int range = 0; range < 5; ++range) {
      const double probability =
          std::clamp(0.3 * ease + 0.2 * (range + 1) + random.uniform(-0.1, 0.1), 0.0, 1.0);
      site.probability.push_back(probability);
      site.error_m.push_back(random.uniform() < probability ? 0.05 : 0.3);
    }
    sites.push_back(site);
  }
  return handmade_model(sites, static_cast<std::uint32_t>(block_count));
}

Result<RangeTable> choose(const ErrorModel& model, const ChooseRangesOptions& options) {
  PassContext ctx;
  return choose_ranges(ctx, options, sites_of(model), model.out_of_fold, model);
}

ChooseRangesOptions with(RiskControl risk_control, double alpha = 0.05) {
  ChooseRangesOptions options;
  options.risk_control = risk_control;
  options.alpha = alpha;
  return options;
}

std::vector<double> chosen_m(const RangeTable& table, std::size_t limit) {
  std::vector<double> ranges_m;
  for (std::size_t i = 0; i < table.site_count; ++i) ranges_m.push_back(table.range_m(i, limit));
  return ranges_m;
}

TEST(ChooseRanges, TakesTheShortestProbableRangeAndDilates) {
  ChooseRangesOptions options = with(RiskControl::kFixed);
  options.dilation_m = 1.0;
  const Result<RangeTable> table = choose(five_sites(), options);
  ASSERT_TRUE(table.has_value()) << to_string(table.error());
  ASSERT_TRUE(validate(*table).has_value());
  EXPECT_EQ(chosen_m(*table, 0), (std::vector<double>{10, 20, 20, 30, 30}));
  EXPECT_EQ(table->flags[3 * 2], 0);
  EXPECT_EQ(table->flags[4 * 2], kUnmet);
  EXPECT_EQ(table->promises[0].method, "fixed");
  EXPECT_NEAR(table->promises[0].calibration_miss_share, 0.2, 1e-12);
}

TEST(ChooseRanges, ByMeanDoesAsThePaperDoes) {
  ChooseRangesOptions options;
  options.selection = Selection::kMean;
  const Result<RangeTable> table = choose(five_sites(), options);
  ASSERT_TRUE(table.has_value());
  EXPECT_EQ(chosen_m(*table, 0), (std::vector<double>{10, 10, 20, 10, 30}));
  EXPECT_EQ(chosen_m(*table, 1), (std::vector<double>{10, 10, 10, 10, 10}));
  EXPECT_EQ(table->flags[4 * 2], kUnmet);
  EXPECT_EQ(table->dilation_m, 0.0);
  EXPECT_EQ(table->selection, Selection::kMean);
  EXPECT_FALSE(table->promises[0].is_earned);
}

TEST(ChooseRanges, FallsBackToTheLongestRangeAndSaysSo) {
  std::vector<std::string> warnings;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { warnings.push_back(message); };
  const ErrorModel model = five_sites();
  ASSERT_TRUE(
      choose_ranges(ctx, with(RiskControl::kFixed), sites_of(model), model.out_of_fold, model)
          .has_value());
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0],
            "no range is good enough for 0.1 m at 1 of 5 sites: they look as far as there is, and "
            "are flagged");
}

TEST(ChooseRanges, NeverPromisesWhatTooFewBlocksCannotEarn) {
  for (const RiskControl risk_control : {RiskControl::kConformal, RiskControl::kLearnThenTest}) {
    const Result<RangeTable> table = choose(honest_model(1, 18), with(risk_control));
    ASSERT_TRUE(table.has_value());
    EXPECT_FALSE(table->promises[0].is_earned);
    EXPECT_LE(table->promises[0].calibration_miss_share, 0.05);
    EXPECT_NE(table->promises[0].statement.find("nothing is promised: 18 blocks of 60 m"),
              std::string::npos)
        << table->promises[0].statement;
  }
  EXPECT_NE(choose(honest_model(1, 18), with(RiskControl::kConformal))
                ->promises[0]
                .statement.find("19 can, 0.1 km more"),
            std::string::npos);
}

TEST(ChooseRanges, PromisesNothingElsewhereFromOnePlaceAlone) {
  ErrorModel model = honest_model(1, 60);
  ASSERT_TRUE(choose(model, with(RiskControl::kConformal))->promises[0].is_earned)
      << "its own sites";
  PassContext ctx;
  PredictedError elsewhere = model.out_of_fold;
  std::ranges::fill(elsewhere.out_of_fold, std::uint8_t{0});
  const auto promise_of = [&] {
    return choose_ranges(ctx, with(RiskControl::kConformal), sites_of(model), elsewhere, model)
        ->promises[0];
  };
  EXPECT_FALSE(promise_of().is_earned);
  EXPECT_NE(promise_of().statement.find("one place alone"), std::string::npos);
  model.card.places.push_back(model.card.places[0]);
  EXPECT_TRUE(promise_of().is_earned);
  model.card.reference = ErrorReference::kFullRangeMatch;
  EXPECT_FALSE(promise_of().is_earned) << "a match to the map is no truth";
  EXPECT_NE(promise_of().statement.find("matches to the map itself"), std::string::npos)
      << promise_of().statement;
}

TEST(ChooseRanges, PromisesNothingWhereMostSitesAreUnlikeTheTraining) {
  const ErrorModel model = honest_model(1, 60);
  PassContext ctx;
  PredictedError predicted = model.out_of_fold;
  const auto promise_of = [&](std::size_t unlike_count) {
    std::ranges::fill(predicted.extrapolated, std::uint8_t{0});
    std::fill_n(predicted.extrapolated.begin(), unlike_count, std::uint8_t{1});
    return choose_ranges(ctx, with(RiskControl::kConformal), sites_of(model), predicted, model)
        ->promises[0];
  };
  EXPECT_TRUE(promise_of(1800).is_earned);
  EXPECT_FALSE(promise_of(1801).is_earned);
  EXPECT_NE(promise_of(1801).statement.find("1801 of 3600 sites are unlike"), std::string::npos);
}

TEST(ChooseRanges, PromisesNothingWhereNoRangeReachesTheLimitAnywhere) {
  ErrorModel model = honest_model(1, 60);
  for (double& error_m : model.measured_mean_m) error_m += 0.1;
  const Result<RangeTable> table = choose(model, with(RiskControl::kConformal));
  ASSERT_TRUE(table.has_value());
  EXPECT_FALSE(table->promises[0].is_earned);
  EXPECT_NE(table->promises[0].statement.find("no range reached 0.1 m anywhere, the least error"),
            std::string::npos)
      << table->promises[0].statement;
}

TEST(ChooseRanges, SaysWhatAModelPromisesBeforeThereIsAMap) {
  const std::vector<std::string> enough =
      promises_of(with(RiskControl::kConformal), honest_model(1, 60));
  ASSERT_EQ(enough.size(), 2u) << "a limit each";
  EXPECT_NE(enough[0].find("at most 5 % of places"), std::string::npos) << enough[0];
  const std::vector<std::string> too_few =
      promises_of(with(RiskControl::kConformal), honest_model(1, 18));
  EXPECT_NE(too_few[0].find("km more of measured route"), std::string::npos) << too_few[0];
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
      const Result<RangeTable> table = choose(model, with(risk_control));
      ASSERT_TRUE(table.has_value());
      for (std::size_t limit = 0; limit < 2; ++limit) {
        double missed = 0.0;
        for (std::size_t site = 0; site < table->site_count; ++site) {
          const double error_m = model.measured(site, table->range_index[site * 2 + limit]);
          missed += error_m > model.out_of_fold.limits_m[limit] ? 1.0 : 0.0;
        }
        const double share = missed / table->site_count;
        EXPECT_NEAR(share, table->promises[limit].calibration_miss_share, 1e-9);
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
      const Result<RangeTable> table = choose(model, with(risk_control, alpha));
      ASSERT_TRUE(table.has_value());
      EXPECT_EQ(table->promises[0].is_earned, risk_control != RiskControl::kEmpirical);
      const std::vector<double> now_m = chosen_m(*table, 0);
      for (std::size_t i = 0; i < now_m.size(); ++i) EXPECT_LE(now_m[i], before_m[i]);
      before_m = now_m;
    }
  }
}

TEST(ChooseRanges, ALooserLimitNeverLooksFurther) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const RiskControl risk_control :
         {RiskControl::kConformal, RiskControl::kEmpirical, RiskControl::kFixed}) {
      const Result<RangeTable> table = choose(honest_model(seed, 20), with(risk_control));
      ASSERT_TRUE(table.has_value());
      for (std::size_t i = 0; i < table->site_count; ++i) {
        EXPECT_LE(table->range_m(i, 1), table->range_m(i, 0));
      }
    }
  }
}

TEST(ChooseRanges, SendsExtrapolatedSitesAsFarAsThereIsUnlessToldOtherwise) {
  const ErrorModel model = five_sites();
  PredictedError predicted = model.out_of_fold;
  predicted.extrapolated[0] = 1;
  ChooseRangesOptions options = with(RiskControl::kFixed);
  options.dilation_m = 0.0;
  PassContext ctx;
  const Result<RangeTable> careful = choose_ranges(ctx, options, sites_of(model), predicted, model);
  options.extrapolated_takes_longest = false;
  const Result<RangeTable> trusting =
      choose_ranges(ctx, options, sites_of(model), predicted, model);
  EXPECT_EQ(chosen_m(*careful, 0), (std::vector<double>{30, 10, 20, 10, 30}));
  EXPECT_EQ(chosen_m(*trusting, 0), (std::vector<double>{10, 10, 20, 10, 30}));
  EXPECT_EQ(careful->flags[0], kExtrapolated);
  EXPECT_EQ(trusting->flags[0], kExtrapolated);
}

TEST(ChooseRanges, JudgesSitesWithHistoryByAThresholdOfTheirOwn) {
  // The even cases were told of an earlier drive and are always right at 0.5; the others at 0.9.
  std::vector<HandmadeSite> sites;
  for (std::size_t i = 0; i < 400; ++i) {
    const bool is_told = i >= 200;
    const double doubtful = is_told ? 0.45 : 0.85;
    const double sure = is_told ? 0.55 : 0.95;
    sites.push_back({{doubtful, sure}, {0.2, 0.05}});
  }
  ErrorModel model = handmade_model(sites, 4);
  model.card.knows_history = true;
  for (std::size_t i = 200; i < 400; ++i) {
    model.sites[i].has_history = 1;
    model.out_of_fold.has_history[i] = 1;
    model.sites[i].run = 1;
  }
  const Result<RangeTable> table = choose(model, with(RiskControl::kEmpirical));
  ASSERT_TRUE(table.has_value()) << to_string(table.error());
  const LimitPromise& promise = table->promises[0];
  EXPECT_GT(promise.probability_threshold, 0.85);
  EXPECT_LE(promise.probability_threshold, 0.95);
  EXPECT_GT(promise.history_threshold, 0.45);
  EXPECT_LE(promise.history_threshold, 0.55);
  EXPECT_EQ(chosen_m(*table, 0), std::vector<double>(400, 20.0));
  EXPECT_EQ(promise.block_count, 2u);
  EXPECT_NE(promise.statement.find("elsewhere"), std::string::npos);
}

TEST(ChooseRanges, RefusesHistoryThatTheModelKnowsNothingOf) {
  const ErrorModel model = five_sites();
  PredictedError told = model.out_of_fold;
  told.has_history[2] = 1;
  PassContext ctx;
  const Result<RangeTable> table = choose_ranges(ctx, {}, sites_of(model), told, model);
  ASSERT_FALSE(table.has_value());
  EXPECT_EQ(table.error().code, ErrorCode::kMismatchedInputs);
}

TEST(ChooseRanges, RefusesInputsThatDoNotBelongTogether) {
  const ErrorModel model = five_sites();
  PassContext ctx;
  Sites fewer = sites_of(model);
  fewer.sites.pop_back();
  EXPECT_EQ(choose_ranges(ctx, {}, fewer, model.out_of_fold, model).error().code,
            ErrorCode::kMismatchedInputs);
  PredictedError other = model.out_of_fold;
  other.limits_m[1] = 0.3;
  EXPECT_EQ(choose_ranges(ctx, {}, sites_of(model), other, model).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
