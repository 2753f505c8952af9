#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "compiler/gate/rules/map_figures.h"
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

// A wall that contradicting poses show twice is removed as if it had moved.
TEST(GateOnOneMap, NamesStretchesWhereMuchWasRemovedAsMoving) {
  CompiledMap map = route_map(200);
  EXPECT_EQ(checks_of(judged(map), "removed-share").at(0).verdict, Verdict::kNotJudged);
  map.columns = {{std::string(kRemovedShare), "", std::vector<float>(200, 0.02F)}};
  Check check = checks_of(judged(map), "removed-share").at(0);
  EXPECT_EQ(check.verdict, Verdict::kMet);
  EXPECT_NEAR(check.found, 0.02, 1e-6);
  for (std::size_t site = 100; site < 160; ++site) map.columns[0].values[site] = 0.3F;
  map.columns[0].values[10] = std::numeric_limits<float>::infinity();  // no scan is near
  check = checks_of(judged(map), "removed-share").at(0);
  EXPECT_EQ(check.verdict, Verdict::kViolated);
  EXPECT_EQ(check.place->first_site, 100u);
  EXPECT_EQ(check.place->last_site, 159u);
  EXPECT_NEAR(check.found, (60 * 0.3 + 41 * 0.02) / 101, 1e-6);
  EXPECT_THAT(check.message, HasSubstr("of the returns were removed as moving"));
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

TEST(GateOnOneMap, WarnsOfPosesThatRestOnAnAssumedSpeed) {
  CompiledMap map = route_map(100);
  const auto at_m = [&](std::size_t site) -> Eigen::Vector3d {
    return map.sites.sites[site].T_map_vehicle.translation();
  };
  const Unconstrained assumed = {true, false, false, Substitute::kConstantSpeed};
  const Unconstrained given = {true, false, false, Substitute::kGivenPoses};
  map.trajectory->unconstrained = {{3, 20, 18.0, assumed, 0.9, at_m(3), at_m(20)},
                                   {25, 60, 36.0, assumed, 1.8, at_m(25), at_m(60)},
                                   {61, 90, 29.0, given, {}, at_m(61), at_m(90)}};
  const GateReport report = judged(map);
  EXPECT_TRUE(report.passes());
  const std::vector<Check> checks = checks_of(report, "trajectory-unconstrained");
  ASSERT_EQ(checks.size(), 1U);
  EXPECT_EQ(checks[0].verdict, Verdict::kViolated);
  EXPECT_EQ(checks[0].severity, Severity::kWarning);
  EXPECT_DOUBLE_EQ(checks[0].found, 36.0);
  EXPECT_EQ(checks[0].place->first_site, 25U);
  EXPECT_EQ(checks[0].place->last_site, 60U);
  EXPECT_THAT(checks[0].message,
              HasSubstr("scans 25 to 60: 36.0 m of the way are not constrained along the road; "
                        "constant speed is assumed, +/- 1.8 m"));
  map.trajectory->unconstrained.erase(map.trajectory->unconstrained.begin() + 1);
  const Check short_one = checks_of(judged(map), "trajectory-unconstrained").at(0);
  EXPECT_EQ(short_one.verdict, Verdict::kMet);
  EXPECT_DOUBLE_EQ(short_one.found, 18.0);
  map.trajectory->unconstrained.erase(map.trajectory->unconstrained.begin());
  EXPECT_DOUBLE_EQ(checks_of(judged(map), "trajectory-unconstrained").at(0).found, 0.0);
}

TEST(GateOnOneMap, WarnsOfContradictionsThatWereAccepted) {
  CompiledMap map = route_map(20);
  EXPECT_EQ(checks_of(judged(map), "input-contradictions").at(0).verdict, Verdict::kMet);
  map.notices = {{"given-poses-disagree", "given poses and scans disagree", 2, 3, 4, 69.1, "m"}};
  const Check check = checks_of(judged(map), "input-contradictions").at(0);
  EXPECT_EQ(check.verdict, Verdict::kViolated);
  EXPECT_EQ(check.severity, Severity::kWarning);
  EXPECT_THAT(check.message, HasSubstr("given poses and scans disagree"));
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
  observation.limits = {{0.1, 0.70, 12.0, 0.5, 0.4, 0.3, 20, 0.80},
                        {0.25, 0.97, 10.0, 0.3, 0.2, 0.9, 5, 0.97}};
  return observation;
}

TEST(GateOnOneMap, JudgesWhatADriveObserved) {
  const CompiledMap map = route_map(60);
  const Observation observation = observation_of(map);
  const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
  EXPECT_EQ(checks_of(report, "observed-coverage", 0.1).at(0).verdict, Verdict::kViolated);
  EXPECT_EQ(checks_of(report, "observed-coverage", 0.25).at(0).verdict, Verdict::kMet);
  // Promised 0.95, observed 0.80 of the answered sites.
  EXPECT_NEAR(checks_of(report, "observed-promise", 0.1).at(0).found, 0.15, 1e-12);
  const Check worst = checks_of(report, "observed-worst-stretch", 0.1).at(0);
  EXPECT_EQ(worst.verdict, Verdict::kViolated);
  EXPECT_EQ(worst.place->first_site, 20u);
  EXPECT_EQ(worst.place->last_site, 29u);
}

// Looks at sites; a replay by plan and range at 0.1 m, by looks and range at 0.25 m.
Observation replayed_observation(const CompiledMap& map) {
  Observation observation = observation_of(map);
  observation.looks = {{"look", 0.1, 0.70, 1.2, 0}, {"look", 0.25, 0.97, 0.1, 0}};
  observation.replayed = {{"map", 0.1, 0.99, 0.5, 7},
                          {"map", 0.25, 0.99, 0.5, 7},
                          {"look", 0.25, 0.98, 0.2, 3},
                          {"plan", 0.1, 0.60, 1.5, 0}};
  return observation;
}

TEST(GateOnOneMap, JudgesLooksAndPlanWhereTheEvaluationHasThem) {
  const CompiledMap map = route_map(60);
  const Observation observation = replayed_observation(map);
  const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
  const auto verdict = [&](const char* rule, double limit_m) {
    return checks_of(report, rule, limit_m).at(0).verdict;
  };
  EXPECT_EQ(verdict("observed-look-coverage", 0.1), Verdict::kViolated);
  EXPECT_EQ(verdict("observed-look-coverage", 0.25), Verdict::kMet);
  EXPECT_EQ(verdict("observed-look-time", 0.1), Verdict::kViolated);
  EXPECT_EQ(verdict("observed-look-time", 0.25), Verdict::kMet);
  EXPECT_EQ(verdict("observed-plan-coverage", 0.1), Verdict::kViolated);
  EXPECT_EQ(verdict("observed-plan-coverage", 0.25), Verdict::kNotJudged);
  EXPECT_EQ(verdict("observed-plan-time", 0.1), Verdict::kViolated);
  EXPECT_EQ(verdict("observed-plan-time", 0.25), Verdict::kNotJudged);
  EXPECT_EQ(checks_of(report, "observed-plan-coverage", 0.1)[0].message,
            "by the plan 60.0 % of the scans of drive drive 2 were within 0.1 m; allowed is at "
            "least 80.0 %");
  EXPECT_THAT(checks_of(report, "observed-plan-time", 0.25)[0].message,
              HasSubstr("the evaluation has no replay by a plan within 0.25 m"));
  Observation better = observation;
  better.replayed[3].coverage = 0.998;
  better.replayed[3].time_ratio = 0.08;
  const GateReport passed = judged(map, nullptr, default_gate_settings(), &better);
  EXPECT_EQ(checks_of(passed, "observed-plan-coverage", 0.1).at(0).verdict, Verdict::kMet);
  EXPECT_EQ(checks_of(passed, "observed-plan-time", 0.1).at(0).verdict, Verdict::kMet);
}

TEST(GateOnOneMap, CountsTracksLostByThePlanElseTheLooksElseTheRanges) {
  const CompiledMap map = route_map(60);
  Observation observation = replayed_observation(map);
  const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
  const Check by_plan = checks_of(report, "observed-lost-tracks", 0.1).at(0);
  EXPECT_EQ(by_plan.verdict, Verdict::kMet);
  EXPECT_EQ(by_plan.message,
            "localizing by the plan within 0.1 m lost 0 tracks on drive drive 2; allowed is at "
            "most 0 tracks");
  const Check by_looks = checks_of(report, "observed-lost-tracks", 0.25).at(0);
  EXPECT_EQ(by_looks.verdict, Verdict::kViolated);
  EXPECT_EQ(by_looks.found, 3.0);
  EXPECT_THAT(by_looks.message, HasSubstr("by the looks within 0.25 m lost 3 tracks"));
  observation.replayed = {{"map", 0.1, 0.99, 0.5, 7}};
  EXPECT_EQ(checks_of(judged(map, nullptr, default_gate_settings(), &observation),
                      "observed-lost-tracks", 0.1)
                .at(0)
                .found,
            7.0);
}

TEST(GateOnOneMap, DoesNotJudgeLooksPlanAndTracksThatTheEvaluationLacks) {
  const CompiledMap map = route_map(60);
  const Observation observation = observation_of(map);
  const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
  for (const char* rule : {"observed-lost-tracks", "observed-look-coverage", "observed-look-time",
                           "observed-plan-coverage", "observed-plan-time"}) {
    const std::vector<Check> checks = checks_of(report, rule);
    EXPECT_FALSE(checks.empty()) << rule;
    for (const Check& check : checks) EXPECT_EQ(check.verdict, Verdict::kNotJudged) << rule;
    EXPECT_TRUE(checks_of(judged(map), rule).empty()) << rule << " without an evaluation";
  }
}

TEST(Observation, HasTheLooksAndTheReplaysOfTheEvaluation) {
  const Observation observation = value_of(parse_observation(R"([
    {"name": "evaluation", "facts": {"drive": "d", "site_count": 60, "stretch_m": 100},
     "columns": ["rule", "limit_m", "coverage", "mean_range_m", "time_ratio", "work_ratio",
                 "worst_coverage", "worst_begin_site"],
     "rows": [["map", 0.1, 0.9, 12, 0.5, 0.4, 0.8, 3], ["oracle", 0.1, 1, 9, 0.2, 0.2, 1, 0]]},
    {"name": "evaluation-looks", "facts": {},
     "columns": ["rule", "limit_m", "coverage", "time_ratio", "work_ratio"],
     "rows": [["map", 0.1, 0.96, 0.06, 0.05], ["static", 0.1, 0.96, 0.1, 0.1]]},
    {"name": "continuous-localization", "facts": {},
     "columns": ["rule", "limit_m", "static_range_m", "coverage", "time_ratio", "lost_count"],
     "rows": [["plan", 0.1, 0, 0.998, 0.08, 0], ["look", 0.1, 0, 0.98, 0.1, 13],
              ["static", 0, 50, 0.99, 1, 3]]}])"));
  ASSERT_EQ(observation.limits.size(), 1U);
  ASSERT_EQ(observation.looks.size(), 1U);
  EXPECT_EQ(observation.limits[0].answered_coverage, 0.9) << "the file counts no answers";
  EXPECT_EQ(observation.looks[0].coverage, 0.96);
  EXPECT_EQ(observation.looks[0].time_ratio, 0.06);
  ASSERT_EQ(observation.replayed.size(), 2U);
  EXPECT_EQ(observation.replayed[0].by, "plan");
  EXPECT_EQ(observation.replayed[0].time_ratio, 0.08);
  EXPECT_EQ(observation.replayed[1].lost_count, 13U);
}

TEST(GateOnOneMap, DoesNotCountADriveThatTheMapWasMadeFrom) {
  const CompiledMap map = route_map(60);
  Observation observation = replayed_observation(map);
  for (const DriveOrigin origin :
       {DriveOrigin::kOwn, DriveOrigin::kOtherScans, DriveOrigin::kKnown}) {
    observation.origin = origin;
    const GateReport report = judged(map, nullptr, default_gate_settings(), &observation);
    int observed = 0;
    for (const Check& check : report.checks) {
      if (!check.rule.starts_with("observed-")) continue;
      ++observed;
      EXPECT_EQ(check.verdict, Verdict::kNotJudged) << check.rule;
      EXPECT_THAT(check.message,
                  HasSubstr(origin == DriveOrigin::kOtherScans ? "same drive, other scans"
                                                               : "were made from it"));
    }
    EXPECT_EQ(observed, 10);
  }
}

TEST(GateOnOneMap, RefusesTheEvaluationOfAMapWithAnotherRootDigest) {
  const CompiledMap map = route_map(60);
  Observation observation = observation_of(map);
  const MapSummary summary;
  const GateMap subject{"a.slmap", map, summary};
  observation.root_digest = to_hex(summary.root_digest);
  EXPECT_TRUE(judge({subject, nullptr, &observation}, default_gate_settings(), kToday));
  observation.root_digest = to_hex(sha256("another map"));
  EXPECT_EQ(code_of(judge({subject, nullptr, &observation}, default_gate_settings(), kToday)),
            ErrorCode::kMismatchedInputs);
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

TEST(GateOnTwoMaps, FindsNothingBetweenAMapAndItself) {
  const CompiledMap map = route_map(120);
  EXPECT_TRUE(violations(judged(map, &map)).empty());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const CompiledMap any = random_map({.seed = seed});
    for (const Check& check : judged(any, &any).checks) {
      if (check.rule.find("rise") != std::string::npos ||
          check.rule.find("change") != std::string::npos ||
          check.rule.find("drop") != std::string::npos) {
        EXPECT_NE(check.verdict, Verdict::kViolated) << check.message;
      }
    }
  }
}

// Of 120 sites, 30 expect 9 instead of 5 cm, look 50 instead of 10 m and are unmet.
TEST(GateOnTwoMaps, NamesRulePlaceAndNumbersOfAStretchThatGotWorse) {
  const CompiledMap old_map = route_map(120);
  CompiledMap map = old_map;
  for (std::size_t site = 60; site < 90; ++site) set_site(map, site, {2, 0.09, 0.6, kUnmet});
  sum_up(map);
  const GateReport report = judged(map, &old_map);
  for (const auto& [rule, found] :
       {std::pair("stretch-error-rise", 0.4), std::pair("stretch-range-rise", 40.0),
        std::pair("stretch-coverage-drop", 0.35), std::pair("stretch-unmet", 30.0)}) {
    const std::vector<Check> checks = checks_of(report, rule, 0.1);
    ASSERT_EQ(checks.size(), 1u) << rule;
    EXPECT_EQ(checks[0].verdict, Verdict::kViolated) << rule;
    EXPECT_NEAR(checks[0].found, found, 1e-9) << rule;
    ASSERT_TRUE(checks[0].place) << rule;
    EXPECT_EQ(checks[0].place->first_site, 60u) << rule;
    EXPECT_EQ(checks[0].place->last_site, 89u) << rule;
  }
  EXPECT_THAT(checks_of(report, "stretch-range-rise", 0.1)[0].message,
              HasSubstr("the range within 0.1 m was 10.0 m and is 50.0 m over the worst 20 m"));
  // 0.04 m are 0.16 of the looser limit: allowed is 0.25.
  EXPECT_EQ(checks_of(report, "stretch-error-rise", 0.25).at(0).verdict, Verdict::kMet);
  EXPECT_NEAR(checks_of(report, "mean-range-rise", 0.1).at(0).found, 10.0, 1e-9);
  EXPECT_NEAR(checks_of(report, "coverage-drop", 0.1).at(0).found, 0.0875, 1e-9);
  EXPECT_NEAR(checks_of(report, "unmet-rise", 0.1).at(0).found, 0.25, 1e-9);
  EXPECT_NEAR(checks_of(report, "work-rise", 0.1).at(0).found, 0.2, 1e-9);
  EXPECT_FALSE(report.passes());
  EXPECT_TRUE(judged(old_map, &map).passes()) << "what got better is no finding";
}

TEST(GateOnTwoMaps, BelieveWhatWasMeasuredWhereTheModelSeesNoChange) {
  CompiledMap old_map = route_map(120);
  old_map.measurement.measured_site_count = 120;
  old_map.quality[0].measured_coverage = 0.95;
  CompiledMap map = old_map;
  map.quality[0].measured_coverage = 0.90;
  const Check dropped = checks_of(judged(map, &old_map), "measured-coverage-drop", 0.1).at(0);
  EXPECT_EQ(dropped.verdict, Verdict::kViolated);
  EXPECT_NEAR(dropped.found, 0.05, 1e-12);
  EXPECT_EQ(checks_of(judged(old_map, &map), "measured-coverage-drop", 0.1).at(0).verdict,
            Verdict::kMet);
  map.measurement.measured_site_count = 0;
  EXPECT_EQ(checks_of(judged(map, &old_map), "measured-coverage-drop").at(0).verdict,
            Verdict::kNotJudged);
}

TEST(GateOnTwoMaps, ComparesTheSamePlaceWhereTheFrameMovedAndRouteIsGone) {
  const CompiledMap old_map = route_map(120);
  CompiledMap map = route_map(80);  // the last 40 m are gone
  map.ndt.frame.origin_world_m.x() += 64.0;
  map.sites.frame = map.ndt.frame;
  for (Site& site : map.sites.sites) site.p_map_m.x() -= 64.0;
  const GateReport report = judged(map, &old_map);
  EXPECT_EQ(checks_of(report, "frame-change").at(0).verdict, Verdict::kViolated);
  EXPECT_THAT(checks_of(report, "frame-change")[0].message,
              HasSubstr("origin (640, -64, 0) became (704, -64, 0)"));
  EXPECT_NEAR(checks_of(report, "stretch-range-rise", 0.1).at(0).found, 0.0, 1e-12);
  // The last site stands for 10 m around it.
  const Check lost = checks_of(report, "route-lost").at(0);
  EXPECT_EQ(lost.verdict, Verdict::kViolated);
  EXPECT_TRUE(lost.place->is_of_old);
  EXPECT_EQ(lost.place->first_site, 90u);
  EXPECT_EQ(lost.place->last_site, 119u);
  EXPECT_NEAR(lost.found, 30.0, 1e-9);
}

TEST(GateOnTwoMaps, NamesWhatIsOfAnotherKind) {
  const CompiledMap old_map = route_map(30);
  CompiledMap map = old_map;
  map.release = old_map.release - 1;
  map.definitions = {{"ndt-map", 2}, {"sites", 1}, {"sights", 1}};
  map.sensor.max_range_m += 1.0;
  map.ranges.selection = Selection::kMean;
  map.model.digest[0] = static_cast<std::uint8_t>(map.model.digest[0] + 1);
  map.predicted.out_of_fold.assign(30, 1);
  const GateReport report = judged(map, &old_map);
  EXPECT_EQ(checks_of(report, "release-order").at(0).found, -1.0);
  EXPECT_EQ(checks_of(report, "definition-change").at(0).found, 2.0);
  EXPECT_THAT(checks_of(report, "definition-change")[0].message, HasSubstr("ndt-map v1 became v2"));
  EXPECT_EQ(checks_of(report, "sensor-change").at(0).found, 1.0);
  const Check model = checks_of(report, "model-change").at(0);
  EXPECT_EQ(model.found, 2.0);
  EXPECT_EQ(model.severity, Severity::kNote);
  EXPECT_THAT(model.message, HasSubstr("of 30 became 30 of 30"));
  EXPECT_EQ(checks_of(report, "limits-change").at(0).verdict, Verdict::kViolated);
}

TEST(SitePairs, AreTheNearestSitesByBruteForce) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CompiledMap a = random_map({.seed = seed, .site_count = 60, .extent_m = 40.0});
    const CompiledMap b = random_map({.seed = seed + 100, .site_count = 60, .extent_m = 40.0});
    const SitePairs pairs = pair_sites(a, b);
    for (std::size_t i = 0; i < a.sites.sites.size(); ++i) {
      std::optional<std::uint32_t> best;
      double best_m = b.reach_m;
      for (std::uint32_t j = 0; j < b.sites.sites.size(); ++j) {
        const Eigen::Vector3d off_m = a.sites.sites[i].p_map_m + a.sites.frame.origin_world_m -
                                      b.sites.sites[j].p_map_m - b.sites.frame.origin_world_m;
        if (std::abs(off_m.z()) >= 1.0) continue;  // on another level
        const double away_m = off_m.norm();
        if (best ? away_m < best_m : away_m <= best_m) {
          best = j;
          best_m = away_m;
        }
      }
      EXPECT_EQ(pairs.old_of_new[i], best) << "seed " << seed << " site " << i;
    }
  }
}

TEST(Stretches, WorstIsTheWorstOfAllWindowsAndEveryBadWindowTouchesABadStretch) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const Sites sites = random_map({.seed = seed, .site_count = 120, .run_count = 3}).sites;
    std::vector<double> value;
    for (std::size_t i = 0; i < sites.sites.size(); ++i) value.push_back(random.uniform());
    const StretchSearch search{7.0, Bound::kAtMost};
    double worst = -1.0;
    const std::vector<BadStretch> bad = bad_stretches(sites, value, search, 0.7);
    for (std::size_t first = 0; first < value.size(); ++first) {
      double sum = 0.0;
      for (std::size_t last = first; last < value.size(); ++last) {
        const double length_m = sites.sites[last].s_m - sites.sites[first].s_m;
        if (sites.sites[last].run != sites.sites[first].run || length_m > 7.0) break;
        sum += value[last];
        if (length_m < 7.0) continue;
        const double mean = sum / static_cast<double>(last - first + 1);
        worst = std::max(worst, mean);
        if (mean <= 0.7) continue;
        EXPECT_TRUE(std::ranges::any_of(bad,
                                        [&](const BadStretch& stretch) {
                                          return stretch.first <= last && stretch.last >= first;
                                        }))
            << "seed " << seed << " sites " << first << " to " << last;
      }
    }
    EXPECT_NEAR(worst_stretch(sites, value, search).worst, worst, 1e-12) << "seed " << seed;
    for (const BadStretch& stretch : bad) EXPECT_GT(stretch.worst, 0.7);
  }
}

}  // namespace
}  // namespace sightline
