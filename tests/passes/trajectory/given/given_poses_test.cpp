#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "passes/trajectory/estimate_trajectory.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

// What estimate-trajectory does with poses that come with a drive.

namespace sightline {
namespace {

using testing::HasSubstr;
constexpr double kAzimuthStep_deg = 0.5;

TestDrive given_drive(const BoxWorld& world, std::size_t count, double step_m) {
  const std::vector<Pose> poses = along_street(0.0, count, step_m);
  TestDrive test = drive_through(world, poses, kAzimuthStep_deg);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    test.drive.scans[i].T_world_vehicle = poses[i];
    test.drive.scans[i].source = "scan" + std::to_string(i) + ".pcd";
  }
  return test;
}

struct Outcome {
  Trajectory trajectory;
  std::string warnings;
};

Outcome run(const Drive& drive, const EstimateTrajectoryOptions& options = {}) {
  TestContext ctx(2);
  Outcome outcome{value_of(estimate_trajectory(ctx, options, drive)), ""};
  for (const std::string& warning : ctx.warnings) outcome.warnings += warning + "\n";
  return outcome;
}

EstimateTrajectoryOptions repairing() {
  EstimateTrajectoryOptions options{.bad_poses = BadPoses::kRepair};
  return options;
}

double largest_off_m(const Trajectory& found, const Trajectory& truth) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < truth.poses.size(); ++i) {
    const Eigen::Vector3d off_m =
        found.poses[i].T_map_vehicle.translation() - truth.poses[i].T_map_vehicle.translation();
    largest_m = std::max(largest_m, off_m.norm());
  }
  return largest_m;
}

void expect_refused(const TestDrive& test, const std::string& place, const std::string& words) {
  const Error error = failure_of(estimate_trajectory(TestContext(2), {}, test.drive));
  EXPECT_EQ(error.code, ErrorCode::kMismatchedInputs);
  EXPECT_EQ(error.place, place) << to_string(error);
  EXPECT_THAT(error.message, HasSubstr(words));
}

TEST(GivenPoses, OneThatIsFarOffIsRefusedByNameAndRepairedWhenAllowed) {
  for (const double off_m : {2.0, 20.0, 1e7}) {
    TestDrive test = given_drive(random_street(3), 6, 1.0);
    test.drive.scans[3].T_world_vehicle->translation().y() += off_m;
    char words[96];
    std::snprintf(words, sizeof words, "scan 3 (scan3.pcd) is %.0f", off_m);
    expect_refused(test, "scan 3", words);
    const Outcome repaired = run(test.drive, repairing());
    EXPECT_EQ(repaired.trajectory.source, PoseSource::kRefined);
    EXPECT_EQ(repaired.trajectory.prior_edges, 5U);
    EXPECT_LT(largest_off_m(repaired.trajectory, test.truth), 0.1) << off_m;
    EXPECT_THAT(repaired.warnings, HasSubstr("scan 3"));
  }
}

TEST(GivenPoses, AFirstOneThatIsFarOffIsFound) {
  TestDrive test = given_drive(random_street(3), 5, 1.0);
  test.drive.scans[0].T_world_vehicle->translation().x() -= 50.0;
  expect_refused(test, "scan 0",
                 "1 of 5 given poses of drive test contradict the scans: scan 0 (scan0.pcd) is");
  EXPECT_LT(largest_off_m(run(test.drive, repairing()).trajectory, test.truth), 0.1);
}

TEST(GivenPoses, AJumpThatLastsIsFoundInTheShorterPart) {
  TestDrive test = given_drive(random_street(4), 7, 1.0);
  for (const std::size_t i : {5U, 6U}) {
    test.drive.scans[i].T_world_vehicle->translation().y() -= 20.0;
  }
  expect_refused(
      test, "scan 5",
      "2 of 7 given poses of drive test contradict the scans: scans 5 to 6, of which scan");
}

TEST(GivenPoses, AHeadingTurnedRoundIsRefused) {
  TestDrive test = given_drive(random_street(5), 6, 1.0);
  test.drive.scans[2].T_world_vehicle->rotate(
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  expect_refused(test, "scan 2", "180.0 degrees from the pose that matching finds");
}

TEST(GivenPoses, ASensorThatLooksBackwardsIsRefusedWithAWordOnAxes) {
  TestDrive test = given_drive(random_street(6), 6, 1.0);
  for (ScanInfo& scan : test.drive.scans) {
    scan.T_world_vehicle->rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  }
  const Error error = failure_of(estimate_trajectory(TestContext(2), {}, test.drive));
  EXPECT_THAT(error.message, HasSubstr("lidar_yaw_deg"));
}

// Only two walls: scans do not show how far the vehicle moved, and matching finds no motion.
TEST(GivenPoses, StayWhereScansCannotContradictThem) {
  std::vector<Pose> poses;
  for (int i = 0; i < 6; ++i) poses.push_back(pose_at(1.0 * i, 0.0, 0.0));
  TestDrive test = drive_through(bare_street(), poses, 0.2);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    test.drive.scans[i].T_world_vehicle = poses[i];
    test.drive.scans[i].T_world_vehicle->translation() *= 1.25;
  }
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(outcome.trajectory.source, PoseSource::kGiven) << outcome.warnings;
}

TEST(GivenPoses, ThatBlurTheMapAreRefinedWhichIsSaid) {
  TestDrive test = given_drive(random_street(7), 14, 1.0);
  for (std::size_t i = 0; i < test.drive.scans.size(); ++i) {
    const double off_rad = (i % 2 == 0 ? 0.4 : -0.4) * std::numbers::pi / 180.0;
    test.drive.scans[i].T_world_vehicle->rotate(
        Eigen::AngleAxisd(off_rad, Eigen::Vector3d::UnitZ()));
  }
  const Outcome refined = run(test.drive);
  EXPECT_EQ(refined.trajectory.source, PoseSource::kRefined);
  EXPECT_LT(largest_off_m(refined.trajectory, test.truth), 0.1);
  EXPECT_THAT(refined.warnings, HasSubstr("given poses of drive test are refined"));
  const EstimateTrajectoryOptions kept{.mode = PoseMode::kGiven};
  EXPECT_EQ(run(test.drive, kept).trajectory.source, PoseSource::kGiven);
}

TEST(GivenPoses, ThatAreGoodToTwoCentimetresStayAsTheyAre) {
  TestDrive test = given_drive(random_street(8), 14, 1.0);
  Random random(5);
  for (ScanInfo& scan : test.drive.scans) {
    for (int axis = 0; axis < 3; ++axis) {
      scan.T_world_vehicle->translation()[axis] += 0.02 * random.normal();
    }
    const double off_rad = 0.04 * random.normal() * std::numbers::pi / 180.0;
    scan.T_world_vehicle->rotate(Eigen::AngleAxisd(off_rad, Eigen::Vector3d::UnitZ()));
  }
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(outcome.trajectory.source, PoseSource::kGiven);
  EXPECT_EQ(outcome.warnings, "");
}

}  // namespace
}  // namespace sightline
