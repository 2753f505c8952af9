#include "passes/model/judge/evaluate_ranges.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/handmade_model.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Four sites, three ranges, one limit (0.1 m). Time and work grow with range: 1, 2, 4.
struct Trial {
  Sites sites;
  PredictedError predicted;
  RangeTable ranges;
  MeasuredError judged;
  FactorTable factors;  // lane, lane, canyon, canyon
};

Trial four_sites() {
  const ErrorModel model = handmade_model({{{0.9, 0.9, 0.9}, {0.05, 0.04, 0.03}},
                                           {{0.2, 0.9, 0.9}, {0.08, 0.06, 0.02}},
                                           {{0.6, 0.9, 0.9}, {0.20, 0.12, 0.02}},
                                           {{0.1, 0.2, 0.3}, {0.50, 0.40, 0.30}}},
                                          2);
  Trial trial;
  trial.sites = sites_of(model);
  trial.predicted = model.out_of_fold;
  trial.predicted.limits_m = {0.1};
  trial.predicted.within_probability.clear();
  for (std::size_t i = 0; i < model.out_of_fold.within_probability.size(); i += 2) {
    trial.predicted.within_probability.push_back(model.out_of_fold.within_probability[i]);
  }
  trial.judged.drive = "second";
  trial.judged.looks = trial.ranges.looks = every_return_at({10.0, 20.0, 30.0});
  trial.judged.scan_of_site = {0, 1, 2, 3};
  for (std::size_t i = 0; i < model.measured_mean_m.size(); ++i) {
    ErrorRow row;
    row.mean_m = model.measured_mean_m[i];
    row.mean_work = row.mean_time_ms = static_cast<double>(1 << (i % 3));
    row.max_time_ms = 2.0 * row.mean_time_ms;
    trial.judged.rows.push_back(row);
  }
  trial.ranges.promises.resize(1);
  trial.ranges.promises[0].limit_m = 0.1;
  trial.ranges.promises[0].probability_threshold = 0.8;
  trial.ranges.site_count = 4;
  trial.ranges.range_index = {0, 1, 2, 2};
  trial.ranges.flags = {0, 0, 0, kUnmet};
  trial.ranges.reasons.assign(4, Reason::kModel);
  trial.factors.looks = trial.ranges.looks;
  trial.factors.factors = {"occupancy_ratio"};
  trial.factors.site_count = 4;
  trial.factors.values = {0.7, 0.8, 0.9, 0.7, 0.8, 0.9, 0.5, 0.8, 0.9, 0.5, 0.8, 0.9};
  return trial;
}

Result<Evaluation> evaluate(const Trial& trial, const EvaluateRangesOptions& options = {}) {
  return evaluate_ranges(TestContext(), options, trial.sites, trial.predicted, trial.ranges,
                         trial.factors, trial.judged);
}

TEST(EvaluateRanges, CountsCoverageBesideTime) {
  const Evaluation evaluation = value_of(evaluate(four_sites()));
  ASSERT_TRUE(validate(evaluation).has_value());
  const RuleScore& map = evaluation.score(0, Rule::kMap);  // errors 0.05, 0.06, 0.02, 0.30
  EXPECT_NEAR(map.coverage, 0.75, 1e-12);
  EXPECT_NEAR(map.mean_error_m, 0.43 / 4.0, 1e-12);
  EXPECT_NEAR(map.p95_error_m, 0.06 + 0.85 * 0.24, 1e-12);
  EXPECT_NEAR(map.mean_range_m, 22.5, 1e-12);
  EXPECT_NEAR(map.time_ratio, 11.0 / 16.0, 1e-12);
  EXPECT_NEAR(map.work_ratio, 11.0 / 16.0, 1e-12);
  EXPECT_NEAR(map.max_site_time_ms, 4.0, 1e-12);
  EXPECT_NEAR(map.max_run_time_ms, 8.0, 1e-12);
  EXPECT_NEAR(map.unmet_share, 0.25, 1e-12);
}

TEST(EvaluateRanges, CountsMissesAmongAnsweredSitesAndWhichUnmetSitesAreTruly) {
  Trial trial = four_sites();
  const RuleScore before = value_of(evaluate(trial)).score(0, Rule::kMap);
  EXPECT_EQ(before.answered_miss_share, 0.0) << "the site that misses is not answered";
  EXPECT_EQ(before.truly_unmet_share, 1.0) << "30 m misses there too";
  trial.ranges.range_index = {0, 1, 1, 2};
  trial.ranges.flags = {kUnmet, 0, 0, kUnmet};
  const RuleScore after = value_of(evaluate(trial)).score(0, Rule::kMap);
  EXPECT_NEAR(after.unmet_share, 0.5, 1e-12);
  EXPECT_NEAR(after.answered_miss_share, 0.5, 1e-12) << "0.12 m at the third";
  EXPECT_NEAR(after.truly_unmet_share, 0.5, 1e-12) << "the first is within 0.1 m";
}

TEST(EvaluateRanges, PutsTheOtherRulesBesideTheMap) {
  const Evaluation evaluation = value_of(evaluate(four_sites()));
  const auto chosen = [&](Rule rule) {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < 4; ++i) indices.push_back(evaluation.chosen(0, rule, i));
    return indices;
  };
  using Indices = std::vector<std::size_t>;
  EXPECT_EQ(chosen(Rule::kMap), (Indices{0, 1, 2, 2}));
  EXPECT_EQ(chosen(Rule::kMean), (Indices{0, 1, 0, 2}));  // 0.02, 0.02, 0.08 m; none for the last
  EXPECT_EQ(chosen(Rule::kProbability), (Indices{0, 1, 1, 2}));
  EXPECT_EQ(chosen(Rule::kStaticEqualCoverage), (Indices{2, 2, 2, 2}));
  EXPECT_EQ(chosen(Rule::kStaticLongest), (Indices{2, 2, 2, 2}));
  EXPECT_EQ(chosen(Rule::kOracle), (Indices{0, 0, 2, 2}));
  EXPECT_NEAR(evaluation.score(0, Rule::kMean).coverage, 0.5, 1e-12);
  EXPECT_NEAR(evaluation.score(0, Rule::kOracle).coverage, 0.75, 1e-12);
  EXPECT_NEAR(evaluation.score(0, Rule::kOracle).unmet_share, 0.25, 1e-12);
  EXPECT_NEAR(evaluation.score(0, Rule::kStaticLongest).time_ratio, 1.0, 1e-12);
}

TEST(EvaluateRanges, FillsThePapersFirstTable) {
  const Result<Evaluation> evaluation = evaluate(four_sites());
  ASSERT_EQ(evaluation->statics.size(), 3u);
  const StaticScore& score = evaluation->statics[1];
  EXPECT_EQ(score.range_m, 20.0);
  EXPECT_NEAR(score.mean_error_m, 0.62 / 4.0, 1e-12);
  EXPECT_NEAR(score.mean_time_ms, 2.0, 1e-12);
  EXPECT_NEAR(score.max_site_time_ms, 2.0, 1e-12);
  EXPECT_NEAR(score.max_run_time_ms, 4.0, 1e-12);
  const std::string text = to_text(*evaluation, MapFrame{});
  EXPECT_NE(text.find("Table I."), std::string::npos);
  EXPECT_NE(text.find("error (cm)           20.8  15.5   9.2"), std::string::npos) << text;
}

TEST(EvaluateRanges, ScoresPerfectPredictionsAsPerfect) {
  Trial trial = four_sites();
  for (std::size_t i = 0; i < trial.judged.rows.size(); ++i) {
    trial.predicted.mean_m[i] = trial.judged.rows[i].mean_m;
    trial.predicted.within_probability[i] = trial.judged.rows[i].mean_m <= 0.1 ? 1.0 : 0.0;
  }
  const Result<Evaluation> evaluation = evaluate(trial);
  for (const StaticScore& score : evaluation->statics) {
    EXPECT_NEAR(score.r_squared, 1.0, 1e-12);
    EXPECT_NEAR(score.rmse_m, 0.0, 1e-12);
  }
  ASSERT_EQ(evaluation->reliability.size(), 2u);
  EXPECT_EQ(evaluation->reliability[0].observed, 0.0);
  EXPECT_EQ(evaluation->reliability[1].observed, 1.0);
  EXPECT_EQ(evaluation->reliability[0].count + evaluation->reliability[1].count, 12u);
}

TEST(EvaluateRanges, FindsTheWorstStretchOfRoute) {
  const EvaluateRangesOptions options{.stretch_m = 2.0};
  const Result<Evaluation> evaluation = evaluate(four_sites(), options);
  const RuleScore& map = evaluation->score(0, Rule::kMap);
  EXPECT_NEAR(map.worst_coverage, 0.5, 1e-12);
  EXPECT_EQ(map.worst_begin_site, 2u);
}

TEST(EvaluateRanges, AWorstStretchLiesInOneRun) {
  Trial trial = four_sites();
  trial.sites.sites[3].run = 1;
  const EvaluateRangesOptions options{.stretch_m = 2.0};
  const Result<Evaluation> evaluation = evaluate(trial, options);
  const RuleScore& map = evaluation->score(0, Rule::kMap);  // only the last site misses
  EXPECT_NEAR(map.worst_coverage, 1.0, 1e-12) << "its run is shorter than a stretch";
  EXPECT_EQ(map.worst_begin_site, 0u);
  EXPECT_EQ(map.worst_end_site, 1u);
}

TEST(EvaluateRanges, ScoresEachTypeOfStreet) {
  const Evaluation evaluation = value_of(evaluate(four_sites()));
  ASSERT_EQ(evaluation.kinds.size(), 2 * kRuleCount);
  const KindScore& canyon = evaluation.kinds[1];  // of the map: errors 0.02, 0.30
  EXPECT_EQ(canyon.kind, PlaceKind::kCanyon);
  EXPECT_EQ(canyon.site_count, 2u);
  EXPECT_NEAR(canyon.site_share, 0.5, 1e-12);
  EXPECT_NEAR(canyon.coverage, 0.5, 1e-12);
  EXPECT_NEAR(canyon.mean_error_m, 0.16, 1e-12);
  EXPECT_NEAR(canyon.time_ratio, 1.0, 1e-12);
  for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
    const KindScore& a = evaluation.kinds[2 * rule];
    const KindScore& b = evaluation.kinds[2 * rule + 1];
    EXPECT_NEAR(a.coverage * a.site_share + b.coverage * b.site_share,
                evaluation.score(0, static_cast<Rule>(rule)).coverage, 1e-12);
  }
}

TEST(EvaluateRanges, SaysNothingOfStreetsWhereTheMapHoldsNoFactors) {
  Trial trial = four_sites();
  trial.factors = {};
  const Evaluation evaluation = value_of(evaluate(trial));
  EXPECT_TRUE(evaluation.kinds.empty());
  EXPECT_EQ(evaluation.sites[0].kind, PlaceKind::kUnknown);
}

TEST(EvaluateRanges, JudgesOnlySitesWithAScan) {
  Trial trial = four_sites();
  trial.judged.scan_of_site[3] = -1;
  const Result<Evaluation> evaluation = evaluate(trial);
  EXPECT_EQ(evaluation->sites.size(), 3u);
  EXPECT_NEAR(evaluation->score(0, Rule::kMap).coverage, 1.0, 1e-12);
}

TEST(EvaluateRanges, NoRuleBeatsTheOracle) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    Trial trial = four_sites();
    for (ErrorRow& row : trial.judged.rows) row.mean_m = random.uniform(0.0, 0.2);
    for (double& mean_m : trial.predicted.mean_m) mean_m = random.uniform(0.0, 0.2);
    const Evaluation evaluation = value_of(evaluate(trial));
    const RuleScore& oracle = evaluation.score(0, Rule::kOracle);
    for (std::size_t i = 0; i < kRuleCount; ++i) {
      const RuleScore& score = evaluation.score(0, static_cast<Rule>(i));
      EXPECT_LE(score.coverage, oracle.coverage + 1e-12);
      EXPECT_LE(score.worst_coverage, score.coverage + 1e-12);
    }
  }
}

TEST(EvaluateRanges, RefusesADriveThatNeverComesNear) {
  Trial trial = four_sites();
  trial.judged.scan_of_site.assign(4, -1);
  EXPECT_EQ(evaluate(trial).error().code, ErrorCode::kNoOverlap);
}

TEST(EvaluateRanges, RefusesInputsThatDoNotBelongTogether) {
  Trial sites = four_sites();
  sites.sites.sites.pop_back();
  EXPECT_EQ(evaluate(sites).error().code, ErrorCode::kMismatchedInputs);
  Trial factors = four_sites();
  factors.factors.site_count = 3;
  factors.factors.values.resize(3 * factors.factors.values_per_site());
  EXPECT_EQ(evaluate(factors).error().code, ErrorCode::kMismatchedInputs);
  Trial ranges = four_sites();
  ranges.judged.looks[2].range_m = 35.0;
  EXPECT_EQ(evaluate(ranges).error().code, ErrorCode::kMismatchedInputs);
  Trial limits = four_sites();
  limits.ranges.promises[0].limit_m = 0.2;
  EXPECT_EQ(evaluate(limits).error().code, ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
