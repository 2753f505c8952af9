#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/compiler/gate/gate_on_map.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(GateOnOneMap, PassesAGoodOneAndSaysWhatWasAsked) {
  const GateReport report = judged(route_map(200));
  EXPECT_TRUE(report.passes());
  EXPECT_TRUE(violations(report).empty());
  const Check coverage = checks_of(report, "expected-coverage", 0.1).at(0);
  EXPECT_EQ(coverage.verdict, Verdict::kMet);
  EXPECT_DOUBLE_EQ(coverage.found, 0.95);
  EXPECT_DOUBLE_EQ(*coverage.allowed, 0.80);
  EXPECT_EQ(coverage.message,
            "expected coverage within 0.1 m is 95.0 %; allowed is at least 80.0 %");
  EXPECT_NEAR(checks_of(report, "expected-work", 0.25).at(0).found, 0.2, 1e-12);
  EXPECT_EQ(checks_of(report, "mean-range", 0.1).at(0).verdict, Verdict::kNotJudged);
  EXPECT_DOUBLE_EQ(checks_of(report, "mean-range", 0.1).at(0).found, 10.0);
  EXPECT_NEAR(checks_of(report, "trajectory-residual").at(0).found, 0.012, 1e-12);
  EXPECT_NEAR(checks_of(report, "model-r-squared").at(0).found, 0.375, 1e-12);
}

// 40 of 200 sites look 50 m with P = 0.2: coverage (160 x 0.95 + 40 x 0.2) / 200 = 0.8.
TEST(GateOnOneMap, NamesTheWorstStretchWithItsNumbers) {
  CompiledMap map = route_map(200);
  for (std::size_t site = 100; site < 140; ++site) {
    set_site(map, site, {2, 0.2, 0.2, kUnmet});
  }
  sum_up(map);
  GateSettings settings = default_gate_settings();
  settings.stretch_m = 30.0;
  const GateReport report = judged(map, nullptr, settings);
  EXPECT_NEAR(checks_of(report, "expected-coverage", 0.1).at(0).found, 0.80, 1e-12);
  EXPECT_EQ(checks_of(report, "unmet-share", 0.1).at(0).found, 0.2);
  EXPECT_EQ(checks_of(report, "unmet-stretch", 0.1).at(0).found, 39.0);
  const std::vector<Check> worst = checks_of(report, "worst-stretch", 0.1);
  ASSERT_EQ(worst.size(), 1u);
  EXPECT_EQ(worst[0].verdict, Verdict::kViolated);
  EXPECT_NEAR(worst[0].found, 0.2, 1e-12);
  EXPECT_EQ(worst[0].place->first_site, 100u);
  EXPECT_EQ(worst[0].place->last_site, 139u);
  EXPECT_EQ(worst[0].place->middle_world_m, Eigen::Vector3d(640.0 + 119.0, -64.0, 1.8));
  EXPECT_THAT(worst[0].message, HasSubstr("sites 100 to 139 (run 0, 100 to 139 m, around "));
  EXPECT_FALSE(report.passes());
}

TEST(GateOnOneMap, TellsTwoBadStretchesApart) {
  CompiledMap map = route_map(300);
  for (std::size_t site = 50; site < 80; ++site) set_site(map, site, {2, 0.2, 0.1, 0});
  for (std::size_t site = 200; site < 240; ++site) set_site(map, site, {2, 0.2, 0.3, 0});
  GateSettings settings = default_gate_settings();
  settings.stretch_m = 20.0;
  const std::vector<Check> worst = checks_of(judged(map, nullptr, settings), "worst-stretch", 0.1);
  ASSERT_EQ(worst.size(), 2u);
  EXPECT_EQ(worst[0].place->first_site, 50u);
  EXPECT_EQ(worst[0].place->last_site, 79u);
  EXPECT_NEAR(worst[0].found, 0.1, 1e-12);
  EXPECT_EQ(worst[1].place->first_site, 200u);
  EXPECT_EQ(worst[1].place->last_site, 239u);
}

TEST(GateOnOneMap, TakesThresholdsForSingleLimitsAndJudgesNothingWithoutOne) {
  GateSettings settings = default_gate_settings();
  settings.rules["expected-coverage"].threshold.at_limits = {{0.25, 0.995}};
  settings.rules["mean-range"].threshold.allowed = 9.0;
  settings.rules["mean-range"].severity = Severity::kNote;
  const GateReport report = judged(route_map(50), nullptr, settings);
  EXPECT_EQ(checks_of(report, "expected-coverage", 0.1).at(0).verdict, Verdict::kMet);
  EXPECT_EQ(checks_of(report, "expected-coverage", 0.25).at(0).verdict, Verdict::kViolated);
  EXPECT_EQ(checks_of(report, "mean-range", 0.1).at(0).severity, Severity::kNote);
  EXPECT_EQ(report.violations(Severity::kNote), 2u);
}

TEST(GateOnOneMap, RefusesPiecesThatNobodyExplainedAndNamesTheirScans) {
  CompiledMap map = route_map(20);
  map.trajectory->pieces = {{0, 0, 60, 25.0, {0.0, 0.0, 0.0}},
                            {60, 6'000'000'000, 54, 30.0, {0.0, 0.0, 0.0}}};
  const GateReport report = judged(map);
  EXPECT_FALSE(report.passes());
  const Check pieces = checks_of(report, "trajectory-pieces").at(0);
  EXPECT_EQ(pieces.verdict, Verdict::kViolated);
  EXPECT_DOUBLE_EQ(pieces.found, 2.0);
  EXPECT_THAT(pieces.message, HasSubstr("one begins at scan 60"));
}

TEST(GateOnOneMap, SaysWhatItCannotJudge) {
  CompiledMap map = route_map(20);
  map.factors = {};
  map.sharpness.reset();
  map.trajectory.reset();
  const GateReport report = judged(map);
  for (const char* rule :
       {"expected-work", "plane-thickness", "less-sharp-than-given", "thicker-than-given",
        "trajectory-pieces", "scan-overlap", "trajectory-residual", "trajectory-turn-residual"}) {
    ASSERT_EQ(checks_of(report, rule).size(), 1u) << rule;
    EXPECT_EQ(checks_of(report, rule)[0].verdict, Verdict::kNotJudged) << rule;
  }
  EXPECT_TRUE(report.passes());
}

// A stricter threshold never violates less, over many maps whose numbers mean nothing.
TEST(GateOnOneMap, IsNeverKinderWithAStricterThreshold) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const CompiledMap map = random_map({.seed = seed, .site_count = 80});
    std::size_t before = 0;
    for (const double least : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      GateSettings settings = default_gate_settings();
      settings.stretch_m = 10.0;
      for (const char* rule : {"expected-coverage", "worst-stretch"}) {
        settings.rules[rule].threshold.allowed = least;
      }
      std::set<std::pair<std::string, double>> bad;
      for (const Check& check : violations(judged(map, nullptr, settings))) {
        if (settings.rules[check.rule].threshold.allowed == least) {
          bad.insert({check.rule, check.limit_m.value_or(0.0)});
        }
      }
      EXPECT_GE(bad.size(), before) << "seed " << seed << " at " << least;
      before = bad.size();
    }
  }
}

Observation observation_of(const CompiledMap& map) {
  Observation observation{"drive 2", map.ranges.site_count, 10.0, {}};
  observation.limits = {{0.1, 0.70, 12.0, 0.5, 0.4, 0.3, 20}, {0.25, 0.97, 10.0, 0.3, 0.2, 0.9, 5}};
  return observation;
}

TEST(GateOnOneMap, JudgesWhatADriveObserved) {
  const CompiledMap map = route_map(60);
  const Observation observation = observation_of(map);
  const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
  EXPECT_EQ(checks_of(report, "observed-coverage", 0.1).at(0).verdict, Verdict::kViolated);
  EXPECT_EQ(checks_of(report, "observed-coverage", 0.25).at(0).verdict, Verdict::kMet);
  // Promised 0.95, observed 0.70.
  EXPECT_NEAR(checks_of(report, "observed-promise", 0.1).at(0).found, 0.25, 1e-12);
  const Check worst = checks_of(report, "observed-worst-stretch", 0.1).at(0);
  EXPECT_EQ(worst.verdict, Verdict::kViolated);
  EXPECT_EQ(worst.place->first_site, 20u);
  EXPECT_EQ(worst.place->last_site, 29u);
}

TEST(GateOnOneMap, RefusesTheEvaluationOfAnotherMapAndADayThatIsNone) {
  const CompiledMap map = route_map(60);
  Observation observation = observation_of(map);
  observation.site_count = 59;
  MapSummary summary;
  const GateMap subject{"a.slmap", map, summary};
  EXPECT_EQ(code_of(judge({subject, nullptr, &observation}, default_gate_settings(), kToday)),
            ErrorCode::kMismatchedInputs);
  for (const char* day : {"", "2026-02-30", "2026-2-03", "yesterday", "2026-06-151"}) {
    EXPECT_EQ(code_of(judge({subject, nullptr, nullptr}, default_gate_settings(), day)),
              ErrorCode::kBadArgument)
        << day;
  }
}

}  // namespace
}  // namespace sightline
