#include "passes/trajectory/estimate_trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

Result<Trajectory> run(const Drive& drive, PoseMode mode, int threads = 1) {
  const EstimateTrajectoryOptions options{.mode = mode};
  return estimate_trajectory(TestContext(threads), options, drive);
}

ErrorCode error_of(const Drive& drive, PoseMode mode) { return failure_of(run(drive, mode)).code; }

// As close as real sensors have it: sparser scans of this world match ring on ring.
constexpr double kAzimuthStep_deg = 0.5;

TestDrive street_drive(std::uint64_t seed, std::size_t count, double step_m) {
  return drive_through(random_street(seed), along_street(0.0, count, step_m), kAzimuthStep_deg);
}

TEST(EstimateTrajectory, TakesGivenPosesInTheDrivesFrame) {
  TestDrive test = street_drive(1, 2, 1.0);
  test.drive.frame.origin_world_m = {64.0, 0.0, -64.0};
  test.drive.scans[0].T_world_vehicle = pose_at(65.0, 2.0, 0.0);
  test.drive.scans[1].T_world_vehicle = pose_at(66.0, 2.0, 0.5);
  const EstimateTrajectoryOptions options{.bad_poses = BadPoses::kIgnore};
  const Trajectory trajectory = value_of(estimate_trajectory(TestContext(), options, test.drive));
  EXPECT_EQ(trajectory.source, PoseSource::kGiven);
  EXPECT_EQ(trajectory.poses[0].T_map_vehicle.translation(), Eigen::Vector3d(1.0, 2.0, 64.0));
  EXPECT_EQ(trajectory.poses[1].T_map_vehicle.translation(), Eigen::Vector3d(2.0, 2.0, 64.0));
  EXPECT_EQ(trajectory.frame, test.drive.frame);
}

// Not slower: at 0.5 m a scan the exact rings of this world lie on each other (street 0 ends 2 m
// off).
TEST(EstimateTrajectory, FollowsStreetsWithoutPoses) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const TestDrive test = street_drive(seed, 8, 0.8 + 0.3 * static_cast<double>(seed));
    const Trajectory trajectory = value_of(run(test.drive, PoseMode::kAuto));
    EXPECT_EQ(trajectory.source, PoseSource::kEstimated);
    EXPECT_EQ(trajectory.odometry_edges, 7u);
    EXPECT_TRUE(validate(trajectory).has_value());
    EXPECT_LT(largest_error_m(trajectory, test.truth), 0.1) << "street " << seed;
    EXPECT_TRUE(trajectory.poses[0].T_map_vehicle.isApprox(Pose::Identity(), 1e-9));
  }
}

void give_poses(TestDrive& test, double scale = 1.0) {
  for (std::size_t i = 0; i < test.drive.scans.size(); ++i) {
    Pose given = test.truth.poses[i].T_map_vehicle;
    given.translation() *= scale;
    test.drive.scans[i].T_world_vehicle = given;
  }
}

// As in a well-known recording, whose poses run 0.86 m a scan where the scans show 0.69 m.
TestDrive too_fast_drive() {
  TestDrive test = street_drive(3, 7, 0.69);
  give_poses(test, 0.86 / 0.69);
  return test;
}

TEST(EstimateTrajectory, CorrectsGivenPosesThatRunTooFast) {
  const TestDrive test = too_fast_drive();
  const Trajectory trajectory = value_of(run(test.drive, PoseMode::kRefine));
  EXPECT_EQ(trajectory.source, PoseSource::kRefined);
  EXPECT_EQ(trajectory.prior_edges, 7u);
  EXPECT_LT(largest_error_m(trajectory, test.truth), 0.1);
}

TEST(EstimateTrajectory, NoticesGivenPosesThatRunTooFastAndRepairsThemWhenAllowed) {
  const TestDrive test = too_fast_drive();
  TestContext ctx;
  EstimateTrajectoryOptions options{.mode = PoseMode::kGiven};
  Trajectory trajectory = value_of(estimate_trajectory(ctx, options, test.drive));
  EXPECT_EQ(trajectory.source, PoseSource::kGiven);
  EXPECT_THAT(ctx.warnings, Contains(AllOf(HasSubstr("scans 0 to 6: the given poses move 5.1"),
                                           HasSubstr("the scans 4.1"))));
  options.bad_poses = BadPoses::kRepair;
  trajectory = value_of(estimate_trajectory(ctx, options, test.drive));
  EXPECT_EQ(trajectory.source, PoseSource::kRefined);
  EXPECT_LT(largest_error_m(trajectory, test.truth), 0.1);
  options.bad_poses = BadPoses::kRefuse;
  const Error refused = failure_of(estimate_trajectory(ctx, options, test.drive));
  EXPECT_EQ(refused.code, ErrorCode::kMismatchedInputs);
  EXPECT_EQ(refused.place, "scan 0");
}

TEST(EstimateTrajectory, DoesNotWarnOfGivenPosesThatAreRight) {
  TestDrive test = street_drive(7, 6, 0.9);
  give_poses(test);
  TestContext ctx;
  require(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_THAT(ctx.warnings, IsEmpty());
}

// Half a minute without scans, 300 m on in a street that looks like the one before.
TEST(EstimateTrajectory, DoesNotWarnOfGivenPosesThatAreRightBehindAPause) {
  TestDrive test = street_drive(7, 12, 0.9);
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < 12; ++i) {
    scans.push_back(*test.drive.store->read(i < 6 ? i : i - 6));
    Pose given = test.truth.poses[i < 6 ? i : i - 6].T_map_vehicle;
    if (i >= 6) {
      given.translation().x() += 300.0;
      test.drive.scans[i].stamp_ns += 30'000'000'000;
    }
    test.drive.scans[i].T_world_vehicle = given;
  }
  test.drive.store = memory_scan_store(scans);
  TestContext ctx;
  const Trajectory trajectory = value_of(estimate_trajectory(ctx, {}, test.drive));
  EXPECT_THAT(ctx.warnings, IsEmpty());
  EXPECT_EQ(trajectory.source, PoseSource::kGiven);
}

// As when a receiver is silent between houses.
TEST(EstimateTrajectory, BridgesAStretchWithoutGivenPosesWithCovariances) {
  TestDrive test = street_drive(8, 9, 1.0);
  for (const std::size_t i : {0U, 1U, 2U, 7U, 8U}) {
    test.drive.scans[i].T_world_vehicle = test.truth.poses[i].T_map_vehicle;
  }
  const Trajectory trajectory = value_of(run(test.drive, PoseMode::kAuto));
  EXPECT_EQ(trajectory.source, PoseSource::kRefined);
  EXPECT_EQ(trajectory.prior_edges, 5u);
  EXPECT_LT(largest_error_m(trajectory, test.truth), 0.05);
  EXPECT_TRUE(validate(trajectory).has_value());
  for (const TrajectoryPose& pose : trajectory.poses) {
    EXPECT_GT(pose.covariance.matrix().diagonal().minCoeff(), 0.0);
    EXPECT_LT(std::sqrt(pose.covariance(0, 0)), 1.0);
  }
}

// The second sensor looks backwards from another place in the vehicle.
TEST(EstimateTrajectory, TakesScansOfSeveralSensors) {
  TestDrive test = street_drive(2, 8, 1.0);
  SensorProfile other = test.drive.sensor;
  other.T_vehicle_lidar = other.T_vehicle_lidar * pose_at(-1.0, 0.3, std::numbers::pi);
  test.drive.other_sensors = {other};
  std::vector<Scan> scans = scans_of(test.drive);
  for (std::size_t i = 1; i < 8; i += 2) {
    test.drive.scans[i].sensor_index = 1;
    const Pose T_other_first = other.T_vehicle_lidar.inverse() * test.drive.sensor.T_vehicle_lidar;
    for (Eigen::Vector3d& point_m : scans[i].points_m) point_m = T_other_first * point_m;
  }
  test.drive.store = memory_scan_store(scans);
  EXPECT_LT(largest_error_m(value_of(run(test.drive, PoseMode::kEstimate)), test.truth), 0.1);
}

TEST(EstimateTrajectory, CarriesOnWithGivenPosesWhereAScanDoesNotMatch) {
  TestDrive test = street_drive(4, 4, 1.0);
  std::vector<Scan> scans = scans_of(test.drive);
  scans[2].points_m.assign(1, Eigen::Vector3d(40.0, 40.0, 40.0));
  test.drive.store = memory_scan_store(scans);
  EXPECT_EQ(error_of(test.drive, PoseMode::kEstimate), ErrorCode::kTrajectoryLost);
  EXPECT_EQ(run(test.drive, PoseMode::kEstimate).error().place, "scan 2");
  give_poses(test);
  TestContext ctx;
  const EstimateTrajectoryOptions options{.mode = PoseMode::kRefine};
  const Trajectory trajectory = value_of(estimate_trajectory(ctx, options, test.drive));
  EXPECT_LT(largest_error_m(trajectory, test.truth), 0.3);
  EXPECT_THAT(ctx.warnings, Contains(StartsWith("1 scans do not match the scans before them")));
}

TEST(EstimateTrajectory, GivesTheSameBytesForAnyNumberOfThreads) {
  const TestDrive test = street_drive(5, 4, 0.8);
  EXPECT_EQ(to_bytes(value_of(run(test.drive, PoseMode::kEstimate, 1))),
            to_bytes(value_of(run(test.drive, PoseMode::kEstimate, 2))));
}

TEST(EstimateTrajectory, RefusesBadInput) {
  const TestDrive test = street_drive(6, 2, 1.0);
  EXPECT_EQ(error_of(test.drive, PoseMode::kGiven), ErrorCode::kNoPoses);
  EXPECT_EQ(run(test.drive, PoseMode::kGiven).error().place, "scan 0");
  EXPECT_EQ(error_of(test.drive, PoseMode::kRefine), ErrorCode::kNoPoses);
  TestDrive one_scan = street_drive(6, 1, 1.0);
  EXPECT_EQ(error_of(one_scan.drive, PoseMode::kEstimate), ErrorCode::kDriveTooShort);
}

}  // namespace
}  // namespace sightline
