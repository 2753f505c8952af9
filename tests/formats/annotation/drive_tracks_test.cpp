#include "formats/annotation/drive_tracks.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

DriveTracks small_tracks() {
  DriveTracks tracks;
  tracks.drive = "second";
  tracks.lost_beyond_m = 1.0;
  tracks.limits_m = {0.1};
  tracks.rules = {{TrackChoice::kRange, 0.1, {}},
                  {TrackChoice::kNobody, 0.0, every_return(20.0)},
                  {TrackChoice::kNobody, 0.0, every_return(50.0)}};
  tracks.scans = {{3, 0.0, 0.0}, {4, 1.0, 0.0}};
  tracks.steps = {{20.0, 0.10, 1.0, 100.0, kTrackBegins}, {50.0, 0.20, 3.0, 300.0, 0},
                  {20.0, 0.05, 1.0, 100.0, kTrackBegins}, {20.0, 1.50, 1.0, 100.0, kTrackLost},
                  {50.0, 0.02, 4.0, 400.0, kTrackBegins}, {50.0, 0.04, 4.0, 400.0, 0}};
  return tracks;
}

TEST(DriveTracks, SurvivesTheDisk) { expect_survives_disk(small_tracks()); }

TEST(DriveTracks, ScoresAReplayBesideTheLongestRange) {
  const TrackScore map = score_track(small_tracks(), 0, 0.1);
  EXPECT_NEAR(map.coverage, 0.5, 1e-12) << "0.10 m is within the limit";
  EXPECT_NEAR(map.mean_error_m, 0.15, 1e-12);
  EXPECT_NEAR(map.p95_error_m, 0.195, 1e-12);
  EXPECT_NEAR(map.mean_range_m, 35.0, 1e-12);
  EXPECT_NEAR(map.time_ratio, 0.5, 1e-12);
  EXPECT_NEAR(map.work_ratio, 0.5, 1e-12);
  EXPECT_EQ(map.track_count, 1u);
  EXPECT_EQ(map.lost_count, 0u);
  EXPECT_EQ(score_track(small_tracks(), 1, 0.1).lost_count, 1u);
}

TEST(DriveTracks, PrintsEveryTableWithAsManyCellsAsColumns) {
  for (const Table& table : tables(small_tracks())) {
    EXPECT_FALSE(table.rows.empty()) << table.name;
    for (const std::vector<Cell>& row : table.rows) {
      EXPECT_EQ(row.size(), table.columns.size()) << table.name;
    }
  }
  EXPECT_NE(to_text(small_tracks()).find("static 20 m            50.0"), std::string::npos)
      << to_text(small_tracks());
}

DriveTracks tracks_of_looks() {
  DriveTracks tracks = small_tracks();
  const Look sample{.range_m = 100.0, .return_count = 650, .point_count = 40};
  tracks.rules.insert(tracks.rules.begin() + 1, {{TrackChoice::kLook, 0.1, {}},
                                                 {TrackChoice::kPlan, 0.1, {}},
                                                 {TrackChoice::kNobody, 0.0, sample}});
  const std::vector<TrackStep> more = {
      {100.0, 0.09, 0.2, 20.0, kTrackBegins}, {100.0, 0.08, 0.2, 20.0, 0},
      {100.0, 0.05, 0.1, 10.0, kTrackBegins}, {100.0, 0.06, 0.4, 40.0, kTrackSecondLook},
      {100.0, 0.05, 0.1, 10.0, kTrackBegins}, {100.0, 0.30, 0.1, 10.0, 0}};
  tracks.steps.insert(tracks.steps.begin() + 2, more.begin(), more.end());
  return tracks;
}

TEST(DriveTracks, TellsLooksAndThePlanBesideRanges) {
  const DriveTracks tracks = tracks_of_looks();
  ASSERT_TRUE(validate(tracks)) << to_string(validate(tracks).error());
  expect_survives_disk(tracks);
  EXPECT_EQ(score_track(tracks, 2, 0.1).second_share, 0.5);
  EXPECT_NEAR(score_track(tracks, 2, 0.1).work_ratio, 50.0 / 800.0, 1e-12);
  const Table table = dump(tracks);
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_EQ(table.rows[1][0], Cell{std::string("look")});
  EXPECT_EQ(table.rows[2][0], Cell{std::string("plan")});
  EXPECT_EQ(table.rows[3][3], Cell{std::string("100 m, 650 returns, 40 points")});
  expect_refused<DriveTracks>(
      tracks, {[](DriveTracks& plan_last) { std::swap(plan_last.rules[2], plan_last.rules[3]); },
               [](DriveTracks& no_range) { std::swap(no_range.rules[3], no_range.rules[5]); },
               [](DriveTracks& no_limit) { no_limit.rules[2].limit_m = 0.0; }});
}

TEST(DriveTracks, RefusesWhatMakesNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_refused<DriveTracks>(
      small_tracks(), {[](DriveTracks& fewer) { fewer.steps.pop_back(); },
                       [](DriveTracks& swapped) { std::swap(swapped.rules[0], swapped.rules[1]); },
                       [](DriveTracks& no_number) { no_number.steps[2].error_m = kNan; },
                       [](DriveTracks& flags) { flags.steps[0].flags = 8; }});
}

}  // namespace
}  // namespace sightline
