#include "passes/localize/track_drive.h"

#include <gtest/gtest.h>

#include "passes/map/build_ndt.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

// A street that was mapped, and a second drive along it, a scan every 0.4 m.
struct Street {
  NdtMap map;
  Sites sites;
  RangeTable ranges;  // 15 m, from site 4 on 30 m
  TestDrive second;
};

const Street& street() {
  static const Street kStreet = [] {
    Street made;
    const BoxWorld world = random_street(20);
    std::vector<Eigen::Vector3d> points_m;
    for (int i = 0; i < 16; ++i) {
      Site site;
      site.s_m = i;
      site.T_map_vehicle = pose_at(i, 0.0, 0.0);
      Pose T_map_lidar = site.T_map_vehicle;
      T_map_lidar.translation().z() = 2.0;
      site.p_map_m = T_map_lidar.translation();
      for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 1.0).points_m) {
        points_m.push_back(T_map_lidar * point_m);
      }
      made.sites.sites.push_back(site);
      made.ranges.range_index.push_back(i < 4 ? 0 : 1);
      made.ranges.flags.push_back(0);
    }
    made.map = ndt_from_points(points_m, MapFrame{}, {}, 1);
    made.ranges.looks = every_return_at({15.0, 30.0});
    made.ranges.promises.resize(1);
    made.ranges.promises[0].limit_m = 0.1;
    made.ranges.site_count = 16;
    std::vector<Pose> poses;
    for (int i = 0; i < 18; ++i) poses.push_back(pose_at(0.5 + 0.4 * i, -0.3, 0.02));
    made.second = drive_through(world, poses, 1.0);
    return made;
  }();
  return kStreet;
}

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
  PassContext ctx;
  ctx.threads = threads;
  return track_drive(ctx, options, drive, trajectory, street().map, street().sites,
                     street().ranges);
}

Result<DriveTracks> track(const TrackDriveOptions& options, int threads = 1) {
  return track(options, street().second.drive, street().second.truth, threads);
}

TEST(TrackDrive, FollowsTheDriveFromItsFirstStart) {
  const Result<DriveTracks> tracks = track(near_starts());
  ASSERT_TRUE(tracks.has_value()) << to_string(tracks.error());
  ASSERT_TRUE(validate(*tracks).has_value());
  ASSERT_EQ(tracks->rules.size(), 3u) << "the map's, 15 m, 30 m";
  ASSERT_EQ(tracks->scans.size(), 18u);
  for (std::size_t rule = 0; rule < 3; ++rule) {
    const TrackScore score = score_track(*tracks, rule, 0.1);
    EXPECT_EQ(score.track_count, 1u);
    EXPECT_EQ(score.lost_count, 0u);
    EXPECT_LT(score.mean_error_m, 0.1) << rule;
  }
}

TEST(TrackDrive, LooksUpTheRangeWhereItExpectsToBe) {
  const Result<DriveTracks> tracks = track(near_starts());
  ASSERT_TRUE(tracks.has_value());
  EXPECT_EQ(tracks->step(0, 2).range_m, 15.0);  // x = 1.3 m
  EXPECT_EQ(tracks->step(0, 6).range_m, 15.0);  // x = 2.9 m
  EXPECT_EQ(tracks->step(0, 9).range_m, 30.0);  // x = 4.1 m
  EXPECT_EQ(tracks->step(0, 17).range_m, 30.0);
  EXPECT_EQ(tracks->step(1, 10).range_m, 15.0);
  // Where the map chooses as the static rule does, nothing tells the two replays apart.
  for (std::size_t scan = 0; scan <= 6; ++scan) {
    EXPECT_EQ(tracks->step(0, scan).error_m, tracks->step(1, scan).error_m);
    EXPECT_EQ(tracks->step(0, scan).work, tracks->step(1, scan).work);
  }
}

TEST(TrackDrive, ForetellsFromWhatItFoundAndNotFromTheReference) {
  Trajectory moved = street().second.truth;
  moved.poses[9].T_map_vehicle.translation().z() += 0.05;
  const Result<DriveTracks> tracks = track(near_starts());
  const Result<DriveTracks> judged = track(near_starts(), street().second.drive, moved);
  ASSERT_TRUE(tracks.has_value() && judged.has_value());
  for (std::size_t scan = 0; scan < 18; ++scan) {
    EXPECT_EQ(tracks->step(2, scan).work, judged->step(2, scan).work);
    const bool is_same = tracks->step(2, scan).error_m == judged->step(2, scan).error_m;
    EXPECT_EQ(is_same, scan != 9) << scan;
  }
}

TEST(TrackDrive, BeginsAnewWhereItIsLost) {
  TrackDriveOptions options = near_starts();
  options.lost_beyond_m = 1e-9;
  const Result<DriveTracks> tracks = track(options);
  ASSERT_TRUE(tracks.has_value());
  const TrackScore score = score_track(*tracks, 2, 0.1);
  EXPECT_EQ(score.lost_count, 18u);
  EXPECT_EQ(score.track_count, 18u);
}

TEST(TrackDrive, BeginsAnewAfterScansBesideTheMapAndAfterAPause) {
  Trajectory away = street().second.truth;
  away.poses[5].T_map_vehicle.translation().y() += 100.0;
  const Result<DriveTracks> beside = track(near_starts(), street().second.drive, away);
  ASSERT_TRUE(beside.has_value());
  EXPECT_EQ(beside->scans.size(), 17u);
  EXPECT_EQ(score_track(*beside, 1, 0.1).track_count, 2u);
  TestDrive paused = street().second;
  for (std::size_t i = 9; i < 18; ++i) {
    paused.drive.scans[i].stamp_ns += 5'000'000'000;
    paused.truth.poses[i].stamp_ns += 5'000'000'000;
  }
  const Result<DriveTracks> rested = track(near_starts(), paused.drive, paused.truth);
  ASSERT_TRUE(rested.has_value());
  EXPECT_EQ(score_track(*rested, 1, 0.1).track_count, 2u);
  EXPECT_EQ(rested->step(1, 9).flags & kTrackBegins, kTrackBegins);
}

TEST(TrackDrive, FindsTheSameWithAnyNumberOfThreads) {
  const Result<DriveTracks> one = track(near_starts(), 1);
  const Result<DriveTracks> four = track(near_starts(), 4);
  ASSERT_TRUE(one.has_value() && four.has_value());
  for (std::size_t i = 0; i < one->steps.size(); ++i) {
    EXPECT_EQ(one->steps[i].error_m, four->steps[i].error_m);
    EXPECT_EQ(one->steps[i].work, four->steps[i].work);
    EXPECT_EQ(one->steps[i].flags, four->steps[i].flags);
  }
}

TEST(TrackDrive, RefusesADriveThatNeverComesNear) {
  Trajectory away = street().second.truth;
  for (TrajectoryPose& pose : away.poses) pose.T_map_vehicle.translation().y() += 100.0;
  const Result<DriveTracks> tracks = track(near_starts(), street().second.drive, away);
  ASSERT_FALSE(tracks.has_value());
  EXPECT_EQ(tracks.error().code, ErrorCode::kNoOverlap);
}

TEST(TrackDrive, RefusesInputsThatDoNotBelongTogether) {
  Trajectory fewer = street().second.truth;
  fewer.poses.pop_back();
  EXPECT_EQ(track(near_starts(), street().second.drive, fewer).error().code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
