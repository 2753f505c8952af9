#include "compiler/gate/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/compiler/gate/gate_on_map.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(GateSettings, OverlayTheDefaults) {
  const GateSettings settings = value_of(parse_gate_settings(R"(
gate:
  stretch_m: 60
  fails_at: warning
  rules:
    expected-coverage: 0.9
    unmet-share: {severity: warning, allowed: 0.3, at_limits: {0.25: 0.1}}
    sensor-change: off
    release-order: note
)"));
  EXPECT_EQ(settings.stretch_m, 60.0);
  EXPECT_EQ(settings.change_stretch_m, 20.0);
  EXPECT_EQ(settings.fails_at, Severity::kWarning);
  EXPECT_EQ(settings.rules.at("expected-coverage").threshold.allowed, 0.9);
  EXPECT_EQ(settings.rules.at("expected-coverage").severity, Severity::kError);
  EXPECT_EQ(settings.rules.at("unmet-share").severity, Severity::kWarning);
  EXPECT_EQ(settings.rules.at("unmet-share").threshold.at(0.1), 0.3);
  EXPECT_EQ(settings.rules.at("unmet-share").threshold.at(0.25), 0.1);
  EXPECT_FALSE(settings.rules.at("sensor-change").is_on);
  EXPECT_EQ(settings.rules.at("release-order").severity, Severity::kNote);
}

TEST(GateSettings, MayStandAloneOrInTheConfigurationOfACompile) {
  EXPECT_EQ(parse_gate_settings("stretch_m: 60")->stretch_m, 60.0);
  EXPECT_EQ(parse_gate_settings("mapping: {scans: x}\n")->stretch_m, 100.0);
  EXPECT_EQ(parse_gate_settings("mapping: {scans: x}\ngate: {stretch_m: 60}")->stretch_m, 60.0);
  EXPECT_EQ(parse_gate_settings("gate:\n")->stretch_m, 100.0);
  EXPECT_EQ(parse_gate_settings("")->stretch_m, 100.0);
}

struct Refusal {
  const char* yaml;
  ErrorCode code;
  const char* message;
  const char* place;
};

TEST(GateSettings, RefuseWhatTheyDoNotKnowAndSayWhere) {
  const Refusal refusals[] = {
      {"rules:\n  expected-coverag: 1", ErrorCode::kUnknownKey, "'expected-coverage'", "line 2"},
      {"strech_m: 1", ErrorCode::kUnknownKey, "'stretch_m'", "line 1"},
      {"gate:\n  stretch_m: 60\n  mean-range: 35", ErrorCode::kUnknownKey,
       "'mean-range' is a rule and belongs under gate.rules", "line 3"},
      {"mean-range: 35", ErrorCode::kUnknownKey, "belongs under gate.rules", "line 1"},
      {"stretch_m: -1", ErrorCode::kBadValue, "expected a number", "line 1"},
      {"rules: {unmet-share: sometimes}", ErrorCode::kBadValue, "sometimes", "line 1"},
      {"rules: {unmet-share: {allowed: much}}", ErrorCode::kBadValue, "number", "line 1"},
      {"rules: {unmet-share: .nan}", ErrorCode::kBadValue, "severity", "line 1"},
      {"rules: {expected-coverage: 95}", ErrorCode::kBadValue,
       "'expected-coverage' judges a share: 95 is more than all; write 0.95 or 95 %", "line 1"},
      {"rules: {unmet-share: {at_limits: {0.25: 2.5}}}", ErrorCode::kBadValue,
       "write 0.025 or 2.5 %", "line 1"},
      {"rules: {mean-range: 95 %}", ErrorCode::kBadValue, "95 %", "line 1"},
      {"exceptions: 3", ErrorCode::kBadValue, "list", "line 1"},
      {"exceptions:\n - {rule: '*', reason: r}", ErrorCode::kMissingKey, "until", "line 2"},
      {"exceptions: [{rule: '*', until: 2026-01-01}]", ErrorCode::kMissingKey, "reason", "line 1"},
      {"exceptions: [{rule: x, reason: r, until: 2026-01-01}]", ErrorCode::kUnknownKey, "x",
       "line 1"},
      {"exceptions: [{rule: '*', reason: r, until: 2026-02-30}]", ErrorCode::kBadValue,
       "YYYY-MM-DD", "line 1"},
      {"exceptions: [{rule: '*', reason: r, until: 2026-01-01, circle: [1, 2]}]",
       ErrorCode::kBadValue, "3 numbers", "line 1"},
      {"exceptions: [{rule: '*', reason: r, until: 2026-01-01, box: [1, 2, 0, 4]}]",
       ErrorCode::kBadValue, "box", "line 1"},
      {"exceptions: [{rule: '*', reason: r, until: 2026-01-01, route: {from_m: 3}}]",
       ErrorCode::kMissingKey, "to_m", "line 1"},
      {"rules: [", ErrorCode::kMalformedText, "YAML", "line 1"}};
  for (const Refusal& refusal : refusals) {
    const Error settings = failure_of(parse_gate_settings(refusal.yaml), refusal.yaml);
    EXPECT_EQ(settings.code, refusal.code) << refusal.yaml;
    EXPECT_THAT(settings.message, HasSubstr(refusal.message)) << refusal.yaml;
    EXPECT_EQ(settings.place.substr(0, settings.place.find(',')), refusal.place) << refusal.yaml;
  }
}

TEST(GateSettings, ReadSharesInPercent) {
  const GateSettings settings = value_of(parse_gate_settings(
      "rules:\n  expected-coverage: 95 %\n  unmet-share: {allowed: 2.5%, at_limits: {0.25: 10 %}}\n"
      "  removed-share: 1\n"));
  EXPECT_EQ(settings.rules.at("expected-coverage").threshold.allowed, 0.95);
  const Threshold& unmet = settings.rules.at("unmet-share").threshold;
  EXPECT_EQ(unmet.allowed, 0.025);
  EXPECT_EQ(unmet.at(0.25), 0.1);
  EXPECT_EQ(settings.rules.at("removed-share").threshold.allowed, 1.0);
}

struct WorseRoute {
  CompiledMap before = route_map(120);
  CompiledMap after = before;
  WorseRoute() {
    for (std::size_t site = 60; site < 90; ++site) set_site(after, site, {2, 0.05, 0.95, 0});
    sum_up(after);
  }
  [[nodiscard]] GateReport report(const std::string& exceptions) const {
    const Result<GateSettings> settings = parse_gate_settings(
        "rules: {mean-range-rise: off, work-rise: off}\nexceptions:\n" + exceptions);
    EXPECT_TRUE(settings) << to_string(settings.error());
    return judged(after, &before, *settings);
  }
};

// Sites 60 to 89 stand at world x = 700 to 729, y = -64.
TEST(GateExceptions, CoverAFindingWhoseEverySiteLiesInThePlace) {
  const WorseRoute route;
  const std::string head = " - {rule: stretch-range-rise, reason: roadworks, until: 2026-06-15, ";
  EXPECT_FALSE(route.report(" []").passes());
  EXPECT_TRUE(route.report(head + "circle: [714.5, -64, 14.6]}").passes());
  EXPECT_FALSE(route.report(head + "circle: [714.5, -64, 14.4]}").passes());
  EXPECT_TRUE(route.report(head + "box: [700, -65, 729, -63]}").passes());
  EXPECT_FALSE(route.report(head + "box: [701, -65, 729, -63]}").passes());
  EXPECT_TRUE(route.report(head + "route: {from_m: 60, to_m: 89}}").passes());
  EXPECT_FALSE(route.report(head + "route: {run: 1, from_m: 60, to_m: 89}}").passes());
  EXPECT_FALSE(route.report(head + "limit_m: 0.1}").passes()) << "0.25 m is not excepted";
  const GateReport report = route.report(head + "route: {from_m: 60, to_m: 89}}");
  EXPECT_EQ(report.count(Verdict::kExcepted), 2u);
  EXPECT_EQ(checks_of(report, "stretch-range-rise", 0.1)[0].exception,
            "roadworks (until 2026-06-15)");
}

TEST(GateExceptions, AreFindingsWhenTheyHaveExpiredOrCoverNothing) {
  const WorseRoute route;
  const GateReport expired = route.report(" - {rule: '*', reason: roadworks, until: 2026-06-05}");
  EXPECT_FALSE(expired.passes());
  ASSERT_EQ(checks_of(expired, "exception-expired").size(), 1u);
  EXPECT_EQ(checks_of(expired, "exception-expired")[0].found, 10.0);
  EXPECT_EQ(checks_of(expired, "exception-expired")[0].severity, Severity::kWarning);
  const GateReport unused =
      route.report(" - {rule: frame-change, reason: new origin, until: 2026-12-31}");
  EXPECT_EQ(checks_of(unused, "exception-unused").at(0).verdict, Verdict::kViolated);
}

TEST(Dates, AreDaysThatExist) {
  EXPECT_TRUE(is_date("2024-02-29"));
  EXPECT_FALSE(is_date("2023-02-29"));
  EXPECT_FALSE(is_date("2023-13-01"));
  EXPECT_EQ(days_between("2023-12-31", "2024-03-01"), 61);
  EXPECT_EQ(days_between("2024-03-01", "2024-02-29"), -1);
}

}  // namespace
}  // namespace sightline
