#include "passes/trajectory/released/extend_released.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <bit>
#include <cstdint>

#include "passes/ingest/join_drives.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/undistort_scans.h"
#include "tests/support/swept_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr std::size_t kCount = 16;  // scans of each drive

// Drives through streets, one a day; each from a place of its street, measured so many times as
// large.
struct DayOf {
  std::uint64_t street = 4;
  double from_m = 0.0;
  double scale = 1.0;
};
TestDrive drives(const std::vector<DayOf>& days) {
  std::vector<TestDrive> all;
  for (const DayOf& day : days) {
    const std::vector<Pose> way = along_street(day.from_m, kCount);
    all.push_back(scaled(drive_through(random_street(day.street), way, 0.5), day.scale));
  }
  return joined_days(all);
}

ReleasedPoses shipped(const TestDrive& all, std::size_t days) {
  Drive first = stretch_of(all.drive, 0, days * kCount);
  first.later_parts.resize(days - 1);
  return *release(first, value_of(estimate_trajectory(TestContext(), {}, first)));
}

Result<Trajectory> extended(PassContext& ctx, const Drive& drive, const ReleasedPoses& released,
                            const EstimateTrajectoryOptions& options = {}) {
  PassContext quiet;
  SIGHTLINE_ASSIGN(const Drive first, released_drive(quiet, {}, drive, released));
  SIGHTLINE_ASSIGN(const Trajectory poses, released_trajectory(quiet, {}, drive, released));
  SIGHTLINE_ASSIGN(const Drive straight, undistort_scans(quiet, {}, first, poses));
  return extend_released(ctx, options, drive, straight, released);
}

struct Outcome {
  Trajectory trajectory;
  std::vector<std::string> warnings;
};

Outcome extend(const Drive& drive, const ReleasedPoses& released,
               const EstimateTrajectoryOptions& options = {}) {
  TestContext ctx(2);
  return {value_of(extended(ctx, drive, released, options)), ctx.warnings};
}

void expect_kept(const Trajectory& found, const ReleasedPoses& released) {
  ASSERT_GE(found.poses.size(), released.trajectory.poses.size());
  for (std::size_t i = 0; i < released.trajectory.poses.size(); ++i) {
    const Pose& was = released.trajectory.poses[i].T_map_vehicle;
    const Pose& is = found.poses[i].T_map_vehicle;
    for (Eigen::Index k = 0; k < was.matrix().size(); ++k) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(was.data()[k]),
                std::bit_cast<std::uint64_t>(is.data()[k]))
          << "pose " << i << ", number " << k;
    }
  }
}

TEST(ExtendReleased, KeepsReleasedPosesToTheBitAndAlignsOtherDrivesToThem) {
  const TestDrive all = drives({{4, 0.0}, {4, 6.0}, {4, 12.0}});
  const ReleasedPoses released = shipped(all, 1);
  const Outcome outcome = extend(all.drive, released);
  ASSERT_TRUE(validate(outcome.trajectory).has_value());
  EXPECT_TRUE(outcome.warnings.empty()) << outcome.warnings.front();
  ASSERT_EQ(outcome.trajectory.poses.size(), 3 * kCount);
  expect_kept(outcome.trajectory, released);
  EXPECT_EQ(outcome.trajectory.poses.back().piece, 0U);
  EXPECT_LT(largest_error_m(outcome.trajectory, all.truth), 0.1);
}

TEST(ExtendReleased, NamesADriveThatMeasuresOtherwiseThanReleasedOnes) {
  const TestDrive all = drives({{4, 0.0}, {4, 2.0, 1.01}});
  const Outcome outcome = extend(all.drive, shipped(all, 1));
  EXPECT_EQ(outcome.trajectory.poses.back().piece, 0U);
  ASSERT_EQ(outcome.warnings.size(), 1U);
  EXPECT_THAT(outcome.warnings[0], HasSubstr("drive day 2 measures distances 1.0 % longer than"));
}

TEST(ExtendReleased, OfNothingNewIsWhatWasReleased) {
  const TestDrive all = drives({{4, 0.0}, {4, 4.0}});
  const ReleasedPoses released = shipped(all, 2);
  EXPECT_EQ(to_bytes(extend(all.drive, released).trajectory), to_bytes(released.trajectory));
  Drive second = stretch_of(all.drive, kCount, kCount);
  for (ScanInfo& scan : second.scans) scan.part = 0;
  second.later_parts.clear();
  const Outcome one = extend(second, released);
  ASSERT_EQ(one.trajectory.poses.size(), kCount);
  EXPECT_EQ(one.trajectory.poses[0].T_map_vehicle.matrix(),
            released.trajectory.poses[kCount].T_map_vehicle.matrix());
}

TEST(ExtendReleased, PlacesADriveByItsGivenPoses) {
  TestDrive all = drives({{4, 0.0}, {4, 8.0}});
  for (std::size_t i = 0; i < 2 * kCount; ++i) {
    Pose pose = all.truth.poses[i].T_map_vehicle;
    if (i >= kCount) pose.translation().x() += 0.3;  // another day's receiver
    all.drive.scans[i].T_world_vehicle = pose;
  }
  const ReleasedPoses released = shipped(all, 1);
  ASSERT_NE(released.trajectory.source, PoseSource::kEstimated);
  const Outcome outcome = extend(all.drive, released);
  expect_kept(outcome.trajectory, released);
  EXPECT_LT(largest_error_m(outcome.trajectory, all.truth), 0.1);
}

// A drive that no loop holds is adjusted to planes that both drives measured.
TEST(ExtendReleased, AdjustsADriveWithPosesToPlanesWhereNoLoopHoldsIt) {
  TestDrive all = drives({{4, 0.0}, {4, 8.0}});
  for (std::size_t i = 0; i < 2 * kCount; ++i) {
    Pose pose = all.truth.poses[i].T_map_vehicle;
    if (i >= kCount) pose.translation() += Eigen::Vector3d(0.0, 0.15, 0.1);
    all.drive.scans[i].T_world_vehicle = pose;
  }
  const ReleasedPoses released = shipped(all, 1);
  const EstimateTrajectoryOptions options{.closes_loops = false};
  const Outcome outcome = extend(all.drive, released, options);
  expect_kept(outcome.trajectory, released);
  EXPECT_LT(largest_error_m(outcome.trajectory, all.truth), 0.05);
}

TEST(ExtendReleased, SeparatesADriveThatMeetsNoOtherAndNamesIt) {
  const TestDrive all = drives({{4, 0.0}, {9, 0.0}});
  const ReleasedPoses released = shipped(all, 1);
  const Outcome outcome = extend(all.drive, released);
  expect_kept(outcome.trajectory, released);
  EXPECT_EQ(outcome.trajectory.poses.back().piece, 1U);
  EXPECT_GT(outcome.trajectory.poses.back().T_map_vehicle.translation().x(),
            2.0 * all.drive.sensor.max_range_m);
  ASSERT_EQ(outcome.warnings.size(), 1U);
  EXPECT_THAT(outcome.warnings[0], HasSubstr("drive day 2 does not match"));
}

TEST(ExtendReleased, RefusesWhatIsNotWhatWasShipped) {
  const TestDrive all = drives({{4, 0.0}, {4, 6.0}});
  ReleasedPoses released = shipped(all, 1);
  const auto refused = [&](const Drive& drive) {
    return failure_of(extended(TestContext(2), drive, released));
  };
  released.scans[3] = sha256("another scan");
  EXPECT_EQ(refused(all.drive).code, ErrorCode::kMismatchedInputs);
  EXPECT_THAT(refused(all.drive).message, HasSubstr("15 of its 16 scans"));
  EXPECT_EQ(refused(all.drive).place, "drive test");
  for (Digest& scan : released.scans) scan = sha256("another drive");
  EXPECT_EQ(refused(all.drive).code, ErrorCode::kMismatchedInputs);
  const TestDrive other_way = drives({{4, 6.0}, {4, 0.0}});
  released = shipped(other_way, 2);
  for (std::size_t i = 0; i < kCount; ++i) released.scans[i] = sha256("a drive that is new");
  EXPECT_EQ(refused(other_way.drive).code, ErrorCode::kBadValue);
  EXPECT_EQ(refused(other_way.drive).place, "drive day 2");
}

TEST(ReleasedPoses, ComeBackFromTheirFileAndNotFromADamagedOne) {
  const TestDrive all = drives({{4, 0.0}, {4, 4.0}});
  const ReleasedPoses released = *release(all.drive, all.truth);
  const std::vector<std::byte> bytes = to_bytes(released);
  const ReleasedPoses again = value_of(from_bytes<ReleasedPoses>(bytes));
  EXPECT_EQ(to_bytes(again), bytes);
  EXPECT_EQ(poses_of(all.drive, again).back(), &again.trajectory.poses.back());
  ReleasedPoses fewer = released;
  fewer.scans.pop_back();
  EXPECT_FALSE(validate(fewer).has_value());
  for (std::size_t at = 0; at < bytes.size(); at += 97) {
    std::vector<std::byte> damaged = bytes;
    damaged[at] ^= std::byte{4};
    EXPECT_FALSE(from_bytes<ReleasedPoses>(damaged).has_value()) << at;
  }
}

// Scans whose files give no times, of a sensor that turns while its vehicle drives: those of the
// faster drive are drawn out twice as far.
TEST(ExtendReleased, ComparesUndistortedScansWithTheReleasedOnes) {
  const auto swept = [](double speed_mps, int count) {
    std::vector<double> times_s;
    for (int i = 0; i < count; ++i) times_s.push_back(0.1 * i);
    return drive_swept(random_street(2), winding(-14.0, speed_mps), times_s, PointOrder::kTime);
  };
  const TestDrive fast = swept(10.0, 30);
  const TestDrive slow = swept(5.0, 60);
  const Drive both = *join_drives(TestContext(), {}, fast.drive, {{&slow.drive}});
  const Outcome outcome = extend(both, *release(fast.drive, fast.truth));
  EXPECT_EQ(outcome.trajectory.poses.back().piece, 0U);
  Trajectory truth = fast.truth;
  for (const TrajectoryPose& pose : slow.truth.poses) truth.poses.push_back(pose);
  EXPECT_LT(largest_error_m(outcome.trajectory, truth), 0.03);
}

}  // namespace
}  // namespace sightline
