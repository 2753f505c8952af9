#include "passes/model/judge/evaluate_looks.h"

#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

Look sample(std::uint32_t points) {
  return {.range_m = 100.0, .return_count = 1000, .point_count = points, .is_by_normals = true};
}

// Errors in metres, [site][look]; time and work are those of `cost`.
MeasuredError measured_at(const std::vector<Look>& looks,
                          const std::vector<std::vector<double>>& error_m,
                          const std::vector<double>& cost) {
  MeasuredError measured;
  measured.looks = looks;
  for (const std::vector<double>& of_site : error_m) {
    measured.scan_of_site.push_back(0);
    for (std::size_t look = 0; look < looks.size(); ++look) {
      ErrorRow row;
      row.mean_m = of_site[look];
      row.mean_time_ms = cost[look];
      row.mean_work = 10.0 * cost[look];
      measured.rows.push_back(row);
    }
  }
  return measured;
}

// Four sites and two looks by normals, then one that needs no map; 50 m costs 10.
struct Trial {
  RangeTable choice;
  ByFamily<MeasuredError> judged;
};

Trial make_trial() {
  Trial trial;
  RangeTable& choice = trial.choice;
  choice.looks = {sample(40), sample(80)};
  choice.promises.resize(1);
  choice.promises.front().limit_m = 0.1;
  choice.site_count = 4;
  choice.range_index = {0, 0, 1, 1};
  choice.flags = {0, 0, 0, 0};
  trial.judged = measured_at({every_return(50.0)}, {{0.02}, {0.02}, {0.02}, {0.3}}, {10.0});
  Look without_map = sample(120);
  without_map.is_by_normals = false;
  trial.judged.samples = measured_at(
      {sample(40), sample(80), without_map},
      {{0.05, 0.04, 0.04}, {0.05, 0.04, 0.04}, {0.2, 0.05, 0.2}, {0.5, 0.4, 0.6}}, {1.0, 2.0, 3.0});
  return trial;
}

TEST(EvaluateLooks, JudgesTheMapsLooksBesideTheSameLookEverywhere) {
  const Trial trial = make_trial();
  const LookEvaluation evaluation = value_of(evaluate_looks(trial.choice, trial.judged));
  EXPECT_TRUE(validate(evaluation));
  const LookRuleScore& map = evaluation.score(0, LookRule::kMap);
  EXPECT_DOUBLE_EQ(map.coverage, 0.75);
  EXPECT_DOUBLE_EQ(map.time_ratio, 0.15);
  EXPECT_DOUBLE_EQ(map.work_ratio, 0.15);
  const LookRuleScore& same = evaluation.score(0, LookRule::kSameEverywhere);
  EXPECT_DOUBLE_EQ(same.coverage, 0.75);
  EXPECT_DOUBLE_EQ(same.time_ratio, 0.2) << "80 points everywhere";
}

TEST(EvaluateLooks, CountsMissesAmongAnsweredSitesAndWhichUnmetSitesAreTruly) {
  Trial trial = make_trial();
  trial.choice.flags = {0, kUnmet, 0, kUnmet};
  trial.choice.range_index = {0, 0, 0, 1};
  const LookEvaluation evaluation = *evaluate_looks(trial.choice, trial.judged);
  EXPECT_TRUE(validate(evaluation));
  const LookRuleScore& map = evaluation.score(0, LookRule::kMap);
  EXPECT_EQ(map.unmet_share, 0.5);
  EXPECT_EQ(map.answered_miss_share, 0.5) << "0.2 m at the third";
  EXPECT_EQ(map.truly_unmet_share, 0.5) << "80 points hold the second";
  const LookRuleScore& oracle = evaluation.score(0, LookRule::kOracle);
  EXPECT_EQ(oracle.unmet_share, 0.0);
  EXPECT_EQ(oracle.answered_miss_share, 0.25);
}

TEST(EvaluateLooks, KeepsLooksByNormalsFromTheBaselineWithoutMap) {
  const Trial trial = make_trial();
  const LookEvaluation evaluation = *evaluate_looks(trial.choice, trial.judged);
  const LookRuleScore& without = evaluation.score(0, LookRule::kSameWithoutMap);
  // 120 points reach half of the sites; only every return within 50 m covers what the map does.
  EXPECT_DOUBLE_EQ(without.coverage, 0.75);
  EXPECT_DOUBLE_EQ(without.time_ratio, 1.0);
}

TEST(EvaluateLooks, DoesNotSetUpRangesAloneAsWhatOneDoesWithoutAMap) {
  Trial trial = make_trial();
  const LookEvaluation with = *evaluate_looks(trial.choice, trial.judged);
  EXPECT_TRUE(with.has_baselines);
  EXPECT_NE(to_text(with).find("static-without-map"), std::string::npos);
  MeasuredError& samples = *trial.judged.samples;
  samples.looks.pop_back();
  samples.rows = {samples.rows[0], samples.rows[1], samples.rows[3], samples.rows[4],
                  samples.rows[6], samples.rows[7], samples.rows[9], samples.rows[10]};
  const LookEvaluation without = *evaluate_looks(trial.choice, trial.judged);
  EXPECT_FALSE(without.has_baselines);
  EXPECT_EQ(to_text(without).find("static-without-map"), std::string::npos) << to_text(without);
  EXPECT_EQ(tables(without).front().rows.size(), with.limits_m.size() * (kLookRuleCount - 1));
}

TEST(EvaluateLooks, LetsTheOracleTakeTheCheapestThatMeetsElseTheMostAccurate) {
  const Trial trial = make_trial();
  const LookEvaluation evaluation = *evaluate_looks(trial.choice, trial.judged);
  const LookRuleScore& oracle = evaluation.score(0, LookRule::kOracle);
  EXPECT_DOUBLE_EQ(oracle.coverage, 0.75);
  EXPECT_DOUBLE_EQ(oracle.time_ratio, (1.0 + 1.0 + 2.0 + 2.0) / 40.0);
}

TEST(EvaluateLooks, CallsARuleDearerThatIs) {
  Trial trial = make_trial();
  trial.choice.range_index = {1, 1, 1, 1};
  for (std::size_t site = 0; site < 4; ++site) {
    trial.judged.samples->rows[site * 3].mean_m = 0.01;  // 40 points would do
  }
  const LookEvaluation evaluation = *evaluate_looks(trial.choice, trial.judged);
  EXPECT_NE(to_text(evaluation).find("takes 100 % MORE"), std::string::npos) << to_text(evaluation);
}

TEST(EvaluateLooks, RefusesADriveThatWasMeasuredAtOtherLooks) {
  Trial trial = make_trial();
  trial.judged.samples->looks.front() = sample(41);
  EXPECT_EQ(failure_of(evaluate_looks(trial.choice, trial.judged)).code,
            ErrorCode::kMismatchedInputs);
}

TEST(EvaluateLooks, IsEncodedAndBack) {
  const Trial trial = make_trial();
  const LookEvaluation evaluation = *evaluate_looks(trial.choice, trial.judged);
  ByteWriter writer;
  encode(evaluation, writer);
  const std::vector<std::byte> bytes = writer.take();
  ByteReader reader(bytes);
  LookEvaluation again;
  decode(reader, again);
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(to_text(again), to_text(evaluation));
}

}  // namespace
}  // namespace sightline
