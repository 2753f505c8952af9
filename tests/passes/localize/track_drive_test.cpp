#include "passes/localize/track_drive.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/passes/localize/mapped_street.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Starts a hand's breadth off: what a street of few boxes bears.
TrackDriveOptions near_starts() {
  TrackDriveOptions options;
  options.matching.reference = ErrorReference::kKnownPose;
  options.matching.starts.radius_m = 0.3;
  options.matching.leaf_m = 0.5;
  return options;
}

Result<DriveTracks> track(const TrackDriveOptions& options, const Drive& drive,
                          const Trajectory& trajectory, int threads = 1) {
  return track_drive(TestContext(threads), options, drive, trajectory, street().map, street().sites,
                     street().ranges);
}

Result<DriveTracks> track(const TrackDriveOptions& options, int threads = 1) {
  return track(options, street().second.drive, street().second.truth, threads);
}

TEST(TrackDrive, FollowsTheDriveFromItsFirstStart) {
  const DriveTracks tracks = value_of(track(near_starts()));
  ASSERT_TRUE(validate(tracks).has_value());
  ASSERT_EQ(tracks.rules.size(), 3u) << "the map's, 15 m, 30 m";
  ASSERT_EQ(tracks.scans.size(), 18u);
  for (std::size_t rule = 0; rule < 3; ++rule) {
    const TrackScore score = score_track(tracks, rule, 0.1);
    EXPECT_EQ(score.track_count, 1u);
    EXPECT_EQ(score.lost_count, 0u);
    EXPECT_LT(score.mean_error_m, 0.1) << rule;
  }
}

TEST(TrackDrive, LooksUpTheRangeWhereItExpectsToBe) {
  const DriveTracks tracks = value_of(track(near_starts()));
  EXPECT_EQ(tracks.step(0, 2).range_m, 15.0);  // x = 1.3 m
  EXPECT_EQ(tracks.step(0, 6).range_m, 15.0);  // x = 2.9 m
  EXPECT_EQ(tracks.step(0, 9).range_m, 30.0);  // x = 4.1 m
  EXPECT_EQ(tracks.step(0, 17).range_m, 30.0);
  EXPECT_EQ(tracks.step(1, 10).range_m, 15.0);
  // Where the map chooses as the static rule does, the two replays do not differ.
  for (std::size_t scan = 0; scan <= 6; ++scan) {
    EXPECT_EQ(tracks.step(0, scan).error_m, tracks.step(1, scan).error_m);
    EXPECT_EQ(tracks.step(0, scan).work, tracks.step(1, scan).work);
  }
}

Result<DriveTracks> track_by(const ByFamily<RangeTable>& ranges) {
  return track_drive(TestContext(), near_starts(), street().second.drive, street().second.truth,
                     street().map, street().sites, ranges);
}

LookPlan street_plan(bool doubts) {
  LookPlan plan;
  plan.first = {.range_m = 30.0, .return_count = 500, .point_count = 100};
  plan.second = {.range_m = 30.0, .return_count = 2000, .point_count = 400};
  plan.doubt_above = std::numeric_limits<double>::infinity() * (doubts ? -1.0 : 1.0);
  return plan;
}

TEST(TrackDrive, ReplaysLooksAndThePlanBesideRanges) {
  const DriveTracks tracks = value_of(track_by(ranges_with_looks(street_plan(true))));
  ASSERT_TRUE(validate(tracks)) << to_string(validate(tracks).error());
  ASSERT_EQ(tracks.rules.size(), 7U) << "range, look, plan, two looks and two ranges everywhere";
  const Result<DriveTracks> ranges_alone = track(near_starts());
  for (std::size_t scan = 0; scan < 18; ++scan) {
    EXPECT_EQ(tracks.step(0, scan).error_m, ranges_alone->step(0, scan).error_m);
    EXPECT_EQ(tracks.step(6, scan).error_m, ranges_alone->step(2, scan).error_m);
    // A vehicle tracks from its third scan on.
    EXPECT_EQ((tracks.step(2, scan).flags & kTrackSecondLook) != 0, scan >= 2) << scan;
  }
  for (std::size_t scan = 0; scan <= 6; ++scan) {
    EXPECT_EQ(tracks.step(1, scan).error_m, tracks.step(3, scan).error_m);
  }
  EXPECT_NE(tracks.step(1, 12).work, tracks.step(3, 12).work) << "the denser look is taken";
}

TEST(TrackDrive, ThePlanBeginsWithThePlacesLookWhereThatIsCheaper) {
  const DriveTracks trusted = value_of(track_by(ranges_with_looks(street_plan(false))));
  const auto work_of = [&](std::size_t scan) { return trusted.step(2, scan).work; };
  // 60 points before site 4, then the plan's own 100, since the place's 150 are dearer.
  LookPlan alone = street_plan(false);
  alone.first = ranges_with_looks({}).samples->looks[0];
  const Result<DriveTracks> cheap = track_by(ranges_with_looks(alone));
  EXPECT_EQ(work_of(5), cheap->step(2, 5).work);
  EXPECT_NE(work_of(14), cheap->step(2, 14).work);
  EXPECT_EQ(score_track(trusted, 2, 0.1).second_share, 0.0);
  const DriveTracks without = value_of(track_by(ranges_with_looks({})));
  EXPECT_EQ(without.rules.size(), 6U) << "a map without a plan has no replay of one";
}

TEST(TrackDrive, ForetellsFromWhatItFoundAndNotFromTheReference) {
  Trajectory moved = street().second.truth;
  moved.poses[9].T_map_vehicle.translation().z() += 0.05;
  const DriveTracks tracks = value_of(track(near_starts()));
  const DriveTracks judged = value_of(track(near_starts(), street().second.drive, moved));
  for (std::size_t scan = 0; scan < 18; ++scan) {
    EXPECT_EQ(tracks.step(2, scan).work, judged.step(2, scan).work);
    EXPECT_EQ(tracks.step(2, scan).error_m == judged.step(2, scan).error_m, scan != 9) << scan;
  }
}

TEST(TrackDrive, BeginsAnewWhereItIsLost) {
  TrackDriveOptions options = near_starts();
  options.lost_beyond_m = 1e-9;
  const TrackScore score = score_track(value_of(track(options)), 2, 0.1);
  EXPECT_EQ(score.lost_count, 18u);
  EXPECT_EQ(score.track_count, 18u);
}

TEST(TrackDrive, BeginsAnewAfterScansBesideTheMapAndAfterAPause) {
  Trajectory away = street().second.truth;
  away.poses[5].T_map_vehicle.translation().y() += 100.0;
  const DriveTracks beside = value_of(track(near_starts(), street().second.drive, away));
  EXPECT_EQ(beside.scans.size(), 17u);
  EXPECT_EQ(score_track(beside, 1, 0.1).track_count, 2u);
  TestDrive paused = street().second;
  for (std::size_t i = 9; i < 18; ++i) {
    paused.drive.scans[i].stamp_ns += 5'000'000'000;
    paused.truth.poses[i].stamp_ns += 5'000'000'000;
  }
  const DriveTracks rested = value_of(track(near_starts(), paused.drive, paused.truth));
  EXPECT_EQ(score_track(rested, 1, 0.1).track_count, 2u);
  EXPECT_EQ(rested.step(1, 9).flags & kTrackBegins, kTrackBegins);
}

TEST(TrackDrive, FindsTheSameWithAnyNumberOfThreads) {
  const DriveTracks one = value_of(track(near_starts(), 1));
  const DriveTracks four = value_of(track(near_starts(), 4));
  for (std::size_t i = 0; i < one.steps.size(); ++i) {
    EXPECT_EQ(one.steps[i].error_m, four.steps[i].error_m);
    EXPECT_EQ(one.steps[i].work, four.steps[i].work);
    EXPECT_EQ(one.steps[i].flags, four.steps[i].flags);
  }
}

TEST(TrackDrive, RefusesADriveThatNeverComesNear) {
  Trajectory away = street().second.truth;
  for (TrajectoryPose& pose : away.poses) pose.T_map_vehicle.translation().y() += 100.0;
  EXPECT_EQ(failure_of(track(near_starts(), street().second.drive, away)).code,
            ErrorCode::kNoOverlap);
}

TEST(TrackDrive, RefusesInputsThatDoNotBelongTogether) {
  Trajectory fewer = street().second.truth;
  fewer.poses.pop_back();
  EXPECT_EQ(track(near_starts(), street().second.drive, fewer).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
