#include "compiler/views/verdict/evaluation_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/text/table.h"
#include "tests/compiler/views/report/sources.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

std::string as_json(const std::vector<Table>& tables) {
  std::string text = "[";
  for (const Table& table : tables) {
    if (text.size() > 1) text += ",";
    text += format_table(table, TableFormat::kJson);
  }
  return text + "]";
}

// At every site a scan; the plan is off at every fifth and lost at the first.
DriveTracks tracks_of(const CompiledMap& map) {
  DriveTracks tracks;
  tracks.drive = "evening";
  tracks.lost_beyond_m = 1.0;
  tracks.limits_m = map.predicted.limits_m;
  for (const double limit_m : tracks.limits_m) {
    tracks.rules.push_back({TrackChoice::kRange, limit_m, {}});
  }
  for (const double limit_m : tracks.limits_m) {
    tracks.rules.push_back({TrackChoice::kPlan, limit_m, {}});
  }
  for (const Look& look : map.ranges.looks) {
    tracks.rules.push_back({TrackChoice::kNobody, 0.0, look});
  }
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    const Eigen::Vector3d& p_m = map.sites.sites[site].p_map_m;
    tracks.scans.push_back({static_cast<std::uint32_t>(site), p_m.x(), p_m.y()});
  }
  for (const TrackRule& rule : tracks.rules) {
    for (std::size_t scan = 0; scan < tracks.scans.size(); ++scan) {
      const bool is_off = rule.choice == TrackChoice::kPlan && scan % 5 == 0;
      TrackStep step = {10.0, is_off ? 0.2 : 0.05, 1.0 + rule.look.range_m, 100.0, 0};
      if (is_off && scan == 0) step.flags = kTrackLost;
      tracks.steps.push_back(step);
    }
  }
  return tracks;
}

TEST(EvaluationFigures, AreTheSameFromArtifactsAndFromJson) {
  const MadeSources made = made_sources(3);
  const EvaluationFigures figures = figures_of(made.map, made.evaluation, nullptr);
  EXPECT_EQ(figures.limits.size(), 2U);
  EXPECT_EQ(figures.limits[0].answers.back().kind, AnswerKind::kRange);
  EvaluationFigures parsed = value_of(parse_evaluation(as_json(tables(made.evaluation)), made.map));
  parsed.origin = DriveOrigin::kOther;  // which `evaluate` adds
  EXPECT_EQ(parsed, figures);
}

TEST(EvaluationFigures, AreTheSameFromArtifactsAndFromJsonOfAReplay) {
  const MadeSources made = made_sources(3);
  const DriveTracks tracks = tracks_of(made.map);
  const EvaluationFigures figures = figures_of(made.map, made.evaluation, &tracks);
  const AnswerScore& plan = figures.limits[0].answers.front();
  EXPECT_EQ(plan.kind, AnswerKind::kPlan);
  EXPECT_DOUBLE_EQ(plan.coverage, 0.8);
  EXPECT_EQ(plan.lost_count, 1U);
  EXPECT_EQ(figures.limits[0].constants.size(), made.map.ranges.looks.size());
  std::vector<Table> all = tables(made.evaluation);
  for (Table& table : tables(tracks)) all.push_back(std::move(table));
  EvaluationFigures parsed = value_of(parse_evaluation(as_json(all), made.map));
  parsed.origin = DriveOrigin::kOther;  // which `evaluate` adds
  EXPECT_EQ(parsed, figures);
}

TEST(EvaluationFigures, OfTheMapsOwnDriveAreMarkedInJson) {
  const MadeSources made = made_sources(3);
  std::vector<Table> all = tables(made.evaluation);
  EXPECT_EQ(value_of(parse_evaluation(as_json(all), made.map)).origin, DriveOrigin::kUnknown);
  for (const std::string_view role : kNamesOf<DriveOrigin>) {
    all.front().facts.emplace_back("drive_role", std::string(role));
    const EvaluationFigures figures = value_of(parse_evaluation(as_json(all), made.map));
    EXPECT_EQ(name_of(figures.origin), role);
    all.front().facts.pop_back();
  }
}

TEST(EvaluationFigures, AreRefusedByTheIdOfAnotherMap) {
  const MadeSources made = made_sources(3);
  std::vector<Table> all = tables(made.evaluation);
  all.front().facts.emplace_back("map_id", made.map.map_id);
  EXPECT_TRUE(parse_evaluation(as_json(all), made.map));
  all.front().facts.back().second = std::string("another");
  EXPECT_EQ(failure_of(parse_evaluation(as_json(all), made.map)).code,
            ErrorCode::kMismatchedInputs);
}

// Misses at places that the map calls unmet do not count against its answers.
TEST(EvaluationFigures, CountAnswersApart) {
  MadeSources made = made_sources(3);
  const std::size_t limits = made.map.ranges.promises.size();
  made.map.looks.reset();
  for (std::size_t site = 0; site < made.map.sites.sites.size(); ++site) {
    Site& at = made.map.sites.sites[site];
    at.p_map_m = {100.0 * static_cast<double>(site), 0.0, 0.0};
    for (std::size_t limit = 0; limit < limits; ++limit) {
      made.map.ranges.flags[site * limits + limit] = site % 3 == 0 ? kUnmet : 0;
    }
  }
  DriveTracks tracks = tracks_of(made.map);
  for (std::size_t scan = 0; scan < tracks.scans.size(); ++scan) {
    if (scan % 3 == 0) tracks.steps[scan].error_m = 0.5;  // of the first rule
  }
  const EvaluationFigures figures = figures_of(made.map, made.evaluation, &tracks);
  const AnswerScore& range = figures.limits[0].answers.back();
  EXPECT_LT(range.coverage, 0.7);
  EXPECT_DOUBLE_EQ(range.answered_coverage, 1.0);
}

TEST(EvaluationFigures, OfAnotherMapAreRefused) {
  const MadeSources made = made_sources(3);
  const std::string json = as_json(tables(made.evaluation));
  CompiledMap other = made.map;
  other.ranges.promises.pop_back();
  const auto of_other = parse_evaluation(json, other);
  ASSERT_FALSE(of_other);
  EXPECT_EQ(of_other.error().code, ErrorCode::kMismatchedInputs);
  for (const char* text : {"{}", "[]", "[{\"name\": 1}]", "nothing"}) {
    const auto bad = parse_evaluation(text, made.map);
    ASSERT_FALSE(bad) << text;
    EXPECT_EQ(bad.error().code, ErrorCode::kMalformedText) << text;
    EXPECT_THAT(bad.error().message, HasSubstr("evaluate --json")) << text;
  }
}

}  // namespace
}  // namespace sightline
