// Drives that a trajectory cannot follow from end to end, and those that it can.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "formats/base/units.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;
constexpr double kAzimuthStep_deg = 0.5;

std::vector<Pose> joined(std::vector<Pose> first, const std::vector<Pose>& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

struct Outcome {
  Trajectory trajectory;
  std::vector<std::string> warnings;
};

Outcome run(const Drive& drive) {
  TestContext ctx(2);
  return {value_of(estimate_trajectory(ctx, {}, drive)), ctx.warnings};
}

double largest_error_m(const Trajectory& found, const Trajectory& truth, std::uint32_t piece) {
  std::optional<std::size_t> first;
  double largest_m = 0.0;
  for (std::size_t i = 0; i < found.poses.size(); ++i) {
    if (found.poses[i].piece != piece) continue;
    if (!first) first = i;
    const Pose T_truth_found =
        truth.poses[*first].T_map_vehicle * found.poses[*first].T_map_vehicle.inverse();
    const Pose laid = T_truth_found * found.poses[i].T_map_vehicle;
    largest_m = std::max(largest_m,
                         (laid.translation() - truth.poses[i].T_map_vehicle.translation()).norm());
  }
  return largest_m;
}

std::uint32_t pieces_in(const Trajectory& trajectory) { return trajectory.poses.back().piece + 1; }

TEST(Pieces, AreNotMadeOfADriveThatCanBeFollowedAndEveryOverlapIsKept) {
  const TestDrive test = drive_through(random_street(2), along_street(0.0, 8), kAzimuthStep_deg);
  const Outcome outcome = run(test.drive);
  EXPECT_TRUE(outcome.warnings.empty());
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_FALSE(outcome.trajectory.poses[0].overlap.has_value());
  for (std::size_t i = 1; i < 8; ++i) EXPECT_GT(outcome.trajectory.poses[i].overlap.value(), 0.6);
}

// A hole of 7 m in a recording, which its stamps do not show.
TEST(Pieces, AreNotMadeWhereWhatIsMissingIsFoundAgain) {
  const TestDrive test = drive_through(
      random_street(1), joined(along_street(-8.0, 6), along_street(4.0, 5)), kAzimuthStep_deg);
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.3);
}

TEST(Pieces, AreNotMadeByAQuickTurnOfTheHand) {
  std::vector<Pose> poses = along_street(0.0, 7, 0.7);
  for (std::size_t i = 3; i < 5; ++i) {
    poses[i].linear() *=
        Eigen::AngleAxisd(std::numbers::pi / 3.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  const TestDrive test = drive_through(random_street(5), poses, kAzimuthStep_deg);
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.1);
}

// Another street without a pause: nothing that it sees was seen before.
TEST(Pieces, BeginWhereNothingOverlapsWithAWarningThatNamesScanTimeAndPlace) {
  TestDrive test = drive_through(random_street(3), along_street(0.0, 6), kAzimuthStep_deg);
  const TestDrive other = drive_through(random_street(40), along_street(0.0, 6), kAzimuthStep_deg);
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < 12; ++i) {
    scans.push_back(*(i < 6 ? test : other).drive.store->read(i % 6));
    scans.back().stamp_ns = static_cast<std::int64_t>(i) * kSecond_ns / 10;
  }
  test = drive_of(scans, joined(along_street(0.0, 6), along_street(0.0, 6)));
  test.drive.sensor.azimuth_step_deg = kAzimuthStep_deg;
  const Outcome outcome = run(test.drive);
  EXPECT_TRUE(validate(outcome.trajectory).has_value());
  ASSERT_EQ(pieces_in(outcome.trajectory), 2u);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(outcome.trajectory.poses[i].piece, i < 6 ? 0u : 1u) << i;
  }
  for (const std::uint32_t piece : {0U, 1U}) {
    EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, piece), 0.1);
  }
  ASSERT_EQ(outcome.warnings.size(), 1u);
  EXPECT_THAT(outcome.warnings[0], HasSubstr("begins at scan 6, 0.600 s, after 5."));
  EXPECT_THAT(outcome.warnings[0], HasSubstr("is unknown"));
  // Farther than two sensors see.
  const Eigen::Vector3d apart_m = outcome.trajectory.poses[6].T_map_vehicle.translation() -
                                  outcome.trajectory.poses[5].T_map_vehicle.translation();
  EXPECT_GT(apart_m.x(), 2.0 * test.drive.sensor.max_range_m);
  EXPECT_FALSE(outcome.trajectory.poses[6].overlap.has_value());
}

// The same street, the next day, from where the first day ended: a piece, joined by what it sees.
TEST(Pieces, AreJoinedAgainByScansThatAgreeWhereTheyAre) {
  TestDrive test = drive_through(
      random_street(4), joined(along_street(0.0, 6), along_street(3.0, 6)), kAzimuthStep_deg);
  std::vector<Scan> scans = scans_of(test.drive);
  for (std::size_t i = 0; i < 12; ++i) {
    test.drive.scans[i].stamp_ns += i < 6 ? 0 : 86'400 * kSecond_ns;
    scans[i].stamp_ns = test.drive.scans[i].stamp_ns;
  }
  test.drive.store = memory_scan_store(scans);
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_TRUE(outcome.warnings.empty());
  EXPECT_GE(outcome.trajectory.loop_edges, 2u);
  EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.3);
}

void begin_tuesday(Drive& drive, std::size_t first) {
  for (std::size_t i = first; i < drive.scans.size(); ++i) drive.scans[i].part = 1;
  drive.later_parts = {"tuesday"};
}

// Two drives through one street, the second right behind the first in time, from a place back.
TestDrive two_days() {
  constexpr int kCount = 16;
  TestDrive test = drive_through(random_street(4),
                                 joined(along_street(0.0, kCount), along_street(4.0, kCount)), 0.5);
  begin_tuesday(test.drive, kCount);
  return test;
}

TEST(Pieces, OfTwoDrivesAreJoinedByWhatTheySee) {
  const TestDrive test = two_days();
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_TRUE(outcome.warnings.empty());
  EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.1);
}

// Every scan with its true pose, those of the second drive off by 5 m.
TEST(Pieces, OfTwoDrivesWhosePosesContradictEachOtherAreJoinedByWhatTheySee) {
  for (const double off_m : {0.0, 1.0}) {
    TestDrive test = two_days();
    for (std::size_t i = 0; i < test.drive.scans.size(); ++i) {
      Pose pose = test.truth.poses[i].T_map_vehicle;
      if (test.drive.scans[i].part == 1) pose.translation() += off_m * Eigen::Vector3d(3, 4, 0);
      test.drive.scans[i].T_world_vehicle = pose;
    }
    const Outcome outcome = run(test.drive);
    EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
    EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.1);
    ASSERT_EQ(outcome.warnings.size(), off_m > 0.0 ? 1u : 0u);
    if (off_m == 0.0) continue;
    EXPECT_THAT(outcome.warnings[0], HasSubstr("drive tuesday is 5."));
  }
}

TEST(Pieces, OfADriveThatMeetsNoOtherIsNamed) {
  const TestDrive test = joined_days({drive_through(random_street(4), along_street(0.0, 8), 0.5),
                                      drive_through(random_street(9), along_street(0.0, 8), 0.5)});
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 2u);
  ASSERT_EQ(outcome.warnings.size(), 1u);
  EXPECT_THAT(outcome.warnings[0], HasSubstr("drive day 2 does not match the drives before it"));
}

// The second drive begins in a street that looks like that of the first, and continues in another.
TEST(Pieces, OfADriveThatFitsAtItsBeginningAloneAreNotJoined) {
  constexpr double kAlikeUntil_m = 6.0;
  constexpr int kCount = 41;
  const BoxWorld first = random_street(4);
  BoxWorld alike = first;
  std::erase_if(alike.boxes, [](const TestBox& box) { return box.low_m.x() > kAlikeUntil_m; });
  for (const TestBox& box : random_street(9).boxes) {
    if (box.low_m.x() > kAlikeUntil_m) alike.boxes.push_back(box);
  }
  const TestDrive monday = drive_through(first, along_street(-10.0, kCount), 0.5);
  const TestDrive tuesday = drive_through(alike, along_street(-10.0, kCount), 0.5);
  EXPECT_EQ(pieces_in(run(joined_days({monday, tuesday}).drive).trajectory), 2u);
}

// The second drive begins where the first one ends and goes on: what a few metres say of forty is
// not enough, though here it would be right.
TEST(Pieces, OfADriveThatOnlyTouchesAnotherAreNotJoined) {
  constexpr int kCount = 41;
  const BoxWorld street = random_street(4);
  const std::vector<Pose> first = along_street(-30.0, kCount);
  const double end_m = first.back().translation().x();
  TestDrive test = drive_through(street, joined(first, along_street(end_m - 4.0, kCount)), 0.5);
  begin_tuesday(test.drive, kCount);
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 2u);
  EXPECT_FALSE(outcome.warnings.empty());
}

// A straight street after a pause: walls without any feature, so that the place along it is not
// known.
TEST(Pieces, AreNotJoinedWhereAllPlacesLookAlike) {
  TestDrive test = drive_through(bare_street(), joined(along_street(0.0, 5), along_street(30.0, 5)),
                                 kAzimuthStep_deg);
  for (std::size_t i = 5; i < 10; ++i) test.drive.scans[i].stamp_ns += 60 * kSecond_ns;
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 2u);
  ASSERT_EQ(outcome.warnings.size(), 1u);
  EXPECT_THAT(outcome.warnings[0], HasSubstr("it comes 60.1 s after"));
}

TEST(Pieces, AreRefusedWhereADriveIsMadeOfThem) {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  for (std::uint64_t i = 0; i < 6; ++i) {
    poses.push_back(along_street(0.0, 1).front());
    const Pose T_map_lidar = Eigen::Translation3d(0.0, 0.0, 2.0) * poses.back();
    scans.push_back(scan_world(random_street(20 + i), T_map_lidar, kAzimuthStep_deg));
  }
  const Error refused =
      failure_of(estimate_trajectory(TestContext(2), {}, drive_of(scans, poses).drive));
  EXPECT_EQ(refused.code, ErrorCode::kTrajectoryLost);
  EXPECT_EQ(refused.place, "scan 1");
  EXPECT_THAT(refused.message, HasSubstr("of 5 scans do not match the scans before them"));
}

// Twice the time, twice the way: with the stamps of a recording that lacks every second scan.
TEST(Pieces, AreNotMadeByStepsThatTakeLonger) {
  std::vector<Pose> poses = along_street(0.0, 4);
  poses = joined(poses, along_street(5.0, 3, 2.0));
  TestDrive test = drive_through(random_street(6), poses, kAzimuthStep_deg);
  for (std::size_t i = 4; i < 7; ++i) {
    test.drive.scans[i].stamp_ns += static_cast<std::int64_t>(i - 3) * kSecond_ns / 10;
  }
  const Outcome outcome = run(test.drive);
  EXPECT_EQ(pieces_in(outcome.trajectory), 1u);
  EXPECT_LT(largest_error_m(outcome.trajectory, test.truth, 0), 0.1);
}

}  // namespace
}  // namespace sightline
