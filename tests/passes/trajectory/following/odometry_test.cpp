#include "passes/trajectory/following/odometry.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

std::vector<Pose> along_a_street(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i)
    poses.push_back(pose_at(0.7 * static_cast<double>(i), 0.0, 0.0));
  return poses;
}

// With given poses of all scans overlaps are computed later, and equal those without given poses.
TEST(Overlaps, OfADriveThatWasLedAreThoseOfOneThatWasNot) {
  const std::vector<Pose> poses = along_a_street(90);
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  GivenPoses given;
  for (const Pose& pose : poses) given.emplace_back(pose * test.drive.sensor.T_vehicle_lidar);
  TestContext ctx(2);
  const Odometry alone = value_of(run_odometry(ctx, 50.0, test.drive, GivenPoses(poses.size())));
  const Odometry led = value_of(run_odometry(ctx, 50.0, test.drive, given));
  for (const std::optional<double>& overlap : led.overlap) EXPECT_FALSE(overlap.has_value());
  const std::vector<std::optional<double>> overlaps =
      value_of(overlaps_along(ctx, test.drive, 50.0, led));
  ASSERT_EQ(overlaps.size(), poses.size());
  EXPECT_FALSE(overlaps.front().has_value());
  double sum = 0.0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    ASSERT_TRUE(overlaps[k] && alone.overlap[k]) << k;
    EXPECT_NEAR(*overlaps[k], *alone.overlap[k], 0.1) << k;
    sum += *overlaps[k];
  }
  EXPECT_GT(sum / static_cast<double>(poses.size() - 1), 0.7);
}

TEST(Overlaps, BeginAnewWithEachPiece) {
  const std::vector<Pose> poses = along_a_street(20);
  const TestDrive test = drive_through(random_street(4), poses, 0.5);
  Odometry odometry;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    odometry.T_map_lidar.push_back(poses[k] * test.drive.sensor.T_vehicle_lidar);
    odometry.driven_m.push_back(0.7 * static_cast<double>(k));
    odometry.piece.push_back(k < 10 ? 0 : 1);
  }
  const std::vector<std::optional<double>> overlaps =
      value_of(overlaps_along(TestContext(), test.drive, 50.0, odometry));
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_EQ(overlaps[k].has_value(), k % 10 != 0) << k;
  }
}

Odometry followed(const std::vector<Pose>& poses) {
  const TestDrive test = drive_through(random_street(4), poses, 1.0);
  return value_of(run_odometry(TestContext(2), 50.0, test.drive, GivenPoses(poses.size())));
}

// Surfaces hold both scans well, and the motion between them is measured; no vehicle makes it.
TEST(Leaps, AreOfMotionsThatNoVehicleMakes) {
  std::vector<Pose> poses = along_a_street(40);
  for (std::size_t k = 30; k < poses.size(); ++k) poses[k].translation().x() += 0.8;
  const Odometry odometry = followed(poses);
  ASSERT_TRUE(odometry.piece_starts.empty());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const StepConstraint& step = odometry.constraint[k];
    EXPECT_EQ(step.leap_m.isZero(0.0), k != 30) << k;
    EXPECT_TRUE(step.weak.isZero(0.0)) << k;
  }
  EXPECT_NEAR(odometry.constraint[30].leap_m.x(), 0.8, 0.1);
  EXPECT_NEAR(odometry.constraint[30].leap_m.y(), 0.0, 0.1);
}

TEST(Leaps, AreNoneOfAVehicleThatBrakesHard) {
  std::vector<Pose> poses = {pose_at(0.0, 0.0, 0.0)};
  double step_m = 1.1;
  for (int k = 1; k < 40; ++k) {
    if (k >= 15) step_m = std::max(0.0, step_m - 0.06);
    poses.push_back(pose_at(poses.back().translation().x() + step_m, 0.0, 0.0));
  }
  for (const StepConstraint& step : followed(poses).constraint) {
    EXPECT_TRUE(step.leap_m.isZero(0.0));
  }
}

Drive drive_of(std::size_t scans) {
  Drive drive;
  drive.scans.resize(scans);
  return drive;
}

GivenPoses evenly_given(std::size_t count, double step_m) {
  GivenPoses given;
  for (std::size_t i = 0; i < count; ++i) {
    given.emplace_back(pose_at(step_m * static_cast<double>(i), 0.0, 0.0));
  }
  return given;
}

void expect_runs(const std::vector<ScanRun>& runs, const std::vector<ScanRun>& expected) {
  ASSERT_EQ(runs.size(), expected.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(runs[i].first, expected[i].first) << i;
    EXPECT_EQ(runs[i].begin, expected[i].begin) << i;
    EXPECT_EQ(runs[i].end, expected[i].end) << i;
  }
}

TEST(ScanRuns, OfADriveWithoutPosesIsOneForEachPart) {
  Drive drive = drive_of(2000);
  const GivenPoses none(2000);
  expect_runs(scan_runs(drive, none, 50.0), {{0, 0, 2000}});
  for (std::size_t i = 700; i < 2000; ++i) drive.scans[i].part = 1;
  expect_runs(scan_runs(drive, none, 50.0), {{0, 0, 700}, {700, 700, 2000}});
}

TEST(ScanRuns, OfAGivenWayBeginALocalMapAhead) {
  const Drive drive = drive_of(1001);
  expect_runs(scan_runs(drive, evenly_given(1001, 1.0), 50.0),
              {{0, 0, 250}, {200, 250, 500}, {450, 500, 750}, {700, 750, 1001}});
  // 800 m are four runs, since 200 m are nearer to 250 m than 400 m are; 600 m are two.
  expect_runs(scan_runs(drive, evenly_given(1001, 0.8), 50.0),
              {{0, 0, 250}, {188, 250, 500}, {438, 500, 750}, {688, 750, 1001}});
  expect_runs(scan_runs(drive, evenly_given(1001, 0.6), 50.0), {{0, 0, 500}, {417, 500, 1001}});
  expect_runs(scan_runs(drive, evenly_given(1001, 0.49), 50.0), {{0, 0, 1001}});
  expect_runs(scan_runs(drive, evenly_given(1001, 0.0), 50.0), {{0, 0, 1001}});
}

TEST(ScanRuns, DoNotBeginWhereNoPoseLeads) {
  const Drive drive = drive_of(1001);
  GivenPoses given = evenly_given(1001, 1.0);
  for (std::size_t i = 400; i < 500; ++i) given[i].reset();
  // 0 to 399 is too short to be halved, 500 to 1000 is not.
  expect_runs(scan_runs(drive, given, 50.0), {{0, 0, 750}, {700, 750, 1001}});
}

TEST(ScanRuns, HaveTenScansOfALocalMapHoweverFarAPoseJumps) {
  const Drive drive = drive_of(1001);
  GivenPoses given = evenly_given(1001, 1.0);
  for (std::size_t i = 499; i < 1001; ++i) given[i]->translation().x() += 1e4;
  for (const ScanRun& run : scan_runs(drive, given, 50.0)) {
    EXPECT_TRUE(run.first == 0 || run.begin - run.first >= 10) << run.begin;
  }
}

Pose random_pose(Random& random) {
  return pose_at(random.uniform(-50.0, 50.0), random.uniform(-50.0, 50.0),
                 random.uniform(-3.0, 3.0));
}

TEST(JoinedRuns, AreThatOfOneDrive) {
  Random random(5);
  Odometry whole;
  for (std::uint32_t k = 0; k < 90; ++k) {
    const Pose step = pose_at(1.0, random.uniform(0.0, 0.1), random.uniform(0.0, 0.1));
    whole.T_map_lidar.push_back(k == 0 ? step : whole.T_map_lidar.back() * step);
    whole.is_matched.push_back(k % 7 != 3);
    whole.is_far.push_back(k % 11 == 5);
    whole.overlap.emplace_back(random.uniform(0.0, 1.0));
    whole.piece.push_back(k < 30 ? 0 : k < 50 ? 1 : 2);
    const double step_m = k > 0 && k != 50 ? step.translation().norm() : 0.0;
    whole.driven_m.push_back(k == 0 ? 0.0 : whole.driven_m.back() + step_m);
  }
  whole.T_map_lidar[50] = whole.T_map_lidar[49];  // a part begins where the last ended
  for (std::uint32_t k = 51; k < 90; ++k) {
    whole.T_map_lidar[k] = whole.T_map_lidar[k - 1] * pose_at(1.0, 0.0, 0.05);
    whole.driven_m[k] = whole.driven_m[k - 1] + 1.0;
  }
  whole.is_matched[0] = true;
  whole.is_matched[50] = false;
  whole.piece_starts = {{30, false, 0.2, 0.1}, {50, true, 0.0, 0.0}};
  const std::vector<ScanRun> runs = {{0, 0, 20}, {10, 20, 50}, {50, 50, 90}};
  std::vector<Odometry> followed;
  for (const ScanRun& run : runs) {
    Odometry part;
    const Pose T_own_map = random_pose(random);
    for (std::size_t k = run.first; k < run.end; ++k) {
      part.T_map_lidar.push_back(T_own_map * whole.T_map_lidar[k]);
      part.is_matched.push_back(whole.is_matched[k] || k == run.first);
      part.is_far.push_back(whole.is_far[k]);
      part.overlap.push_back(whole.overlap[k]);
      part.constraint.emplace_back();
      part.piece.push_back(whole.piece[k] - whole.piece[run.first]);
      part.driven_m.push_back(whole.driven_m[k] - whole.driven_m[run.first]);
    }
    if (run.begin == 20) part.piece_starts = {whole.piece_starts[0]};
    followed.push_back(part);
  }
  const Pose T_whole_first = whole.T_map_lidar[0] * followed[0].T_map_lidar[0].inverse();
  const Odometry joined = joined_runs(runs, followed);
  ASSERT_EQ(joined.T_map_lidar.size(), 90u);
  for (std::size_t k = 0; k < 90; ++k) {
    EXPECT_TRUE((T_whole_first * joined.T_map_lidar[k]).isApprox(whole.T_map_lidar[k], 1e-9)) << k;
    EXPECT_NEAR(joined.driven_m[k], whole.driven_m[k], 1e-9) << k;
  }
  EXPECT_EQ(joined.is_matched, whole.is_matched);
  EXPECT_EQ(joined.is_far, whole.is_far);
  EXPECT_EQ(joined.overlap, whole.overlap);
  EXPECT_EQ(joined.piece, whole.piece);
  ASSERT_EQ(joined.piece_starts.size(), 2u);
  EXPECT_EQ(joined.piece_starts[0].scan, 30u);
  EXPECT_EQ(joined.piece_starts[1].scan, 50u);
  EXPECT_TRUE(joined.piece_starts[1].is_time_jump);
}

// 82 m in runs of 41 m, which are followed apart from each other.
TEST(ScanRuns, EndWhereTheVehicleWas) {
  std::vector<Pose> poses;
  for (int i = 0; i < 104; ++i) poses.push_back(pose_at(0.8 * i - 20.0, 0.0, 0.0));
  const TestDrive test = drive_through(random_street(3), poses, 0.5);
  GivenPoses given;
  for (const TrajectoryPose& pose : test.truth.poses) {
    given.emplace_back(pose.T_map_vehicle * test.drive.sensor.T_vehicle_lidar);
  }
  constexpr double kLocalMap_m = 8.0;
  ASSERT_EQ(scan_runs(test.drive, given, kLocalMap_m).size(), 2u);
  const Odometry found = value_of(run_odometry(TestContext(1), kLocalMap_m, test.drive, given));
  const Odometry again = value_of(run_odometry(TestContext(4), kLocalMap_m, test.drive, given));
  ASSERT_EQ(found.T_map_lidar.size(), 104u);
  for (std::size_t k = 0; k < 104; ++k) {
    EXPECT_TRUE(found.is_matched[k]) << k;
    EXPECT_LT((found.T_map_lidar[k].translation() - given[k]->translation()).norm(), 0.1) << k;
    EXPECT_EQ(found.T_map_lidar[k].matrix(), again.T_map_lidar[k].matrix()) << k;
  }
}

}  // namespace
}  // namespace sightline
