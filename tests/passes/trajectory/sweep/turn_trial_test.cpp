#include "passes/trajectory/sweep/turn_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>

#include "passes/ingest/join_drives.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/sweep/undistorted.h"
#include "passes/trajectory/undistort_scans.h"
#include "tests/passes/trajectory/sweep/uneven_turns.h"
#include "tests/support/test_context.h"

// Scans measured while a vehicle steers to and fro: what an inertial unit gains, and when it is not
// believed.

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
constexpr int kScans = 30;

const TestDrive& jerky_drive() {
  static const TestDrive test = timed_drive(random_street(2), jerky, kScans);
  return test;
}

TestDrive with_rates(std::vector<TurnRate> rates) {
  TestDrive test = jerky_drive();
  test.drive.turn_rates = std::move(rates);
  return test;
}

struct Outcome {
  Drive drive;
  std::vector<std::string> warnings;
};

Outcome tried(const TestDrive& test) {
  TestContext ctx;
  return {value_of(with_imu_if_sharper(ctx, test.drive, test.truth)), ctx.warnings};
}

// Root mean square of how far points of undistorted scans are from where they were measured;
// without the first and the last scan, which have poses on one side only.
double error_m(const Drive& straight, const Trajectory& trajectory = jerky_drive().truth) {
  double sum_m2 = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 1; k + 1 < straight.scans.size(); ++k) {
    const Scan raw = *jerky_drive().drive.store->read(k);
    const Scan scan = *straight.store->read(k);
    const Pose T_map_lidar = trajectory.poses[k].T_map_vehicle * straight.sensor.T_vehicle_lidar;
    for (std::size_t i = 0; i < raw.points_m.size(); i += 5) {
      const double time_s = 1e-9 * static_cast<double>(raw.stamp_ns + raw.time_offset_ns[i]);
      const Pose T_map_then = jerky(time_s) * straight.sensor.T_vehicle_lidar;
      sum_m2 += (T_map_lidar * scan.points_m[i] - T_map_then * raw.points_m[i]).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum_m2 / static_cast<double>(count));
}

TEST(TurnTrial, PutsPointsWhereTheyWereMeasured) {
  EXPECT_GT(error_m(undistorted(jerky_drive().drive, jerky_drive().truth)), 0.09);
  ImuErrors errors;
  errors.bias_radps = {0.02, -0.03, 0.05};
  errors.sigma_radps = 0.005;
  for (const TestDrive& test :
       {with_rates(imu_of(jerky, 3.0)), with_rates(imu_of(jerky, 3.0, errors))}) {
    const Outcome outcome = tried(test);
    EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("turn rates are used")));
    EXPECT_EQ(outcome.drive.turn_rates.size(), test.drive.turn_rates.size());
    const Drive straight = undistorted(outcome.drive, test.truth);
    EXPECT_LT(error_m(straight), 0.002);
    EXPECT_TRUE(straight.turn_rates.empty());
  }
}

TEST(TurnTrial, MovesRatesOfAnotherClockAndWarnsByHowMuch) {
  ImuErrors errors;
  errors.ahead_ns = 60'000'000;
  const Outcome outcome = tried(with_rates(imu_of(jerky, 3.0, errors)));
  EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("is 0.06 s ahead of that of the scans"),
                                            HasSubstr("turn rates are used")));
  EXPECT_LT(error_m(undistorted(outcome.drive, jerky_drive().truth)), 0.002);
}

TEST(TurnTrial, RejectsRatesThatMakeScansLessSharp) {
  ImuErrors noisy;
  noisy.sigma_radps = 0.5;
  std::vector<TurnRate> other_axes = imu_of(jerky, 3.0);
  for (TurnRate& rate : other_axes) {
    const Eigen::Vector3d was = rate.rate_rad_per_s;
    rate.rate_rad_per_s = {was.z(), was.x(), was.y()};
  }
  for (const TestDrive& test :
       {with_rates(imu_of(jerky, 3.0, noisy)), with_rates(std::move(other_axes))}) {
    const Outcome outcome = tried(test);
    EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("turn rates are not used")));
    EXPECT_TRUE(outcome.drive.turn_rates.empty());
  }
}

TEST(TurnTrial, AsksNothingWhereRatesAreNotThereOrCoverNoScan) {
  const Outcome none = tried(jerky_drive());
  EXPECT_TRUE(none.warnings.empty());
  EXPECT_EQ(none.drive.store, jerky_drive().drive.store);
  std::vector<TurnRate> later = imu_of(jerky, 1.0);
  for (TurnRate& rate : later) rate.stamp_ns += 100'000'000'000;
  const Outcome outcome = tried(with_rates(std::move(later)));
  EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("they cover no scans")));
  EXPECT_TRUE(outcome.drive.turn_rates.empty());
}

TEST(TurnTrial, IsWhatUndistortScansDoes) {
  const TestDrive test = with_rates(imu_of(jerky, 3.0));
  EXPECT_LT(error_m(value_of(undistort_scans(TestContext(), {}, test.drive, test.truth))), 0.002);
  const Drive even = value_of(undistort_scans(TestContext(), {}, jerky_drive().drive, test.truth));
  EXPECT_GT(error_m(even), 0.09);
}

TEST(TurnTrial, IsOfEachDriveForItself) {
  ImuErrors behind;
  behind.ahead_ns = -60'000'000;
  TestDrive first = with_rates(imu_of(jerky, 3.0, behind));
  ImuErrors ahead;
  ahead.ahead_ns = 60'000'000;
  TestDrive later = with_rates(imu_of(jerky, 3.0, ahead));
  first.drive.name = "mon";
  later.drive.name = "tue";
  const Drive both = *join_drives(TestContext(), {}, first.drive, {{&later.drive}});
  Trajectory truth = first.truth;
  for (TrajectoryPose pose : later.truth.poses) {
    pose.recording_index = both.scans[truth.poses.size()].recording_index;
    pose.stamp_ns = both.scans[truth.poses.size()].stamp_ns;
    truth.poses.push_back(pose);
  }
  TestContext ctx;
  const Drive straight = value_of(undistort_scans(ctx, {}, both, truth));
  EXPECT_THAT(ctx.warnings,
              ElementsAre(HasSubstr("drive mon: the clock of the turn rates is 0.06 s behind"),
                          HasSubstr("drive mon: turn rates are used"),
                          HasSubstr("drive tue: the clock of the turn rates is 0.06 s ahead"),
                          HasSubstr("drive tue: turn rates are used")));
  const std::vector<Drive> days = parts_of(straight);
  ASSERT_EQ(days.size(), 2u);
  EXPECT_LT(error_m(days[0]), 0.002);
  EXPECT_LT(error_m(days[1]), 0.002);
}

// Every second scan is another sensor's, and its pose is interpolated evenly.
TEST(TurnTrial, PutsPointsOfOtherSensorsWhereTheyWereMeasured) {
  TestDrive test = with_rates(imu_of(jerky, 3.0));
  test.drive.other_sensors = {test.drive.sensor};
  for (std::size_t k = 1; k + 1 < test.drive.scans.size(); k += 2) {
    test.drive.scans[k].sensor_index = 1;
    test.truth.poses[k].T_map_vehicle = interpolate(test.truth.poses[k - 1].T_map_vehicle,
                                                    test.truth.poses[k + 1].T_map_vehicle, 0.5);
  }
  const Outcome outcome = tried(test);
  EXPECT_THAT(outcome.warnings, ElementsAre(HasSubstr("turn rates are used")));
  // Positions stay linear, now over 0.2 s.
  EXPECT_LT(error_m(undistorted(outcome.drive, test.truth), test.truth), 0.004);
}

// Parts of work are kept by the names of what they read.
TEST(TurnTrial, NamesOnlyScansAnewThatRatesReach) {
  const TestDrive test = with_rates(imu_of(jerky, 3.0));
  TestDrive changed = test;
  for (TurnRate& rate : changed.drive.turn_rates) {
    if (rate.stamp_ns == 0) rate.rate_rad_per_s.z() += 0.1;
  }
  const Drive even = undistorted(jerky_drive().drive, test.truth);
  const Drive turned = undistorted(test.drive, test.truth);
  const Drive other = undistorted(changed.drive, test.truth);
  EXPECT_NE(turned.store->identity(0), even.store->identity(0));
  EXPECT_NE(turned.store->identity(0), other.store->identity(0));
  EXPECT_EQ(turned.store->identity(kScans - 1), other.store->identity(kScans - 1));
}

Trajectory poses_of(const VehicleMotion& motion, int count, double sigma_rad = 0.0) {
  Random random(3);
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    Pose pose = motion(0.1 * i);
    const Eigen::Vector3d off(random.normal(), random.normal(), random.normal());
    pose.rotate(Eigen::AngleAxisd(sigma_rad * off.norm(), off.normalized()));
    trajectory.poses.push_back(
        {static_cast<std::uint32_t>(i), i * std::int64_t{100'000'000}, pose});
  }
  return trajectory;
}

Pose wandering(double time_s) {
  return pose_at(8.0 * time_s, 0.0, 0.2 * std::sin(1.3 * time_s) + 0.1 * std::sin(3.1 * time_s));
}

TEST(TurnClock, FindsHowFarAClockIsAheadOrBehind) {
  const Trajectory trajectory = poses_of(wandering, 60, 0.0005);
  for (const std::int64_t ahead_ns : {0, 60'000'000, -135'000'000, 400'000'000}) {
    ImuErrors errors;
    errors.ahead_ns = ahead_ns;
    errors.bias_radps = {0.1, -0.2, 0.3};
    errors.sigma_radps = 0.01;
    const std::vector<TurnRate> rates = imu_of(wandering, 6.0, errors);
    const TurnClock clock = turn_clock(trajectory, rates);
    ASSERT_TRUE(clock.is_known);
    EXPECT_NEAR(static_cast<double>(clock.ahead_ns), static_cast<double>(ahead_ns), 10e6);
    EXPECT_GT(clock.explained_moved, 0.95);
    EXPECT_LE(clock.explained_as_is, clock.explained_moved);
    EXPECT_LE(clock.explained_moved, 1.0);
    EXPECT_EQ(moved_by(rates, clock.ahead_ns).front().stamp_ns,
              rates.front().stamp_ns - clock.ahead_ns);
  }
}

TEST(TurnClock, ExplainsNothingByRatesOfAnotherVehicle) {
  const VehicleMotion other = [](double time_s) {
    return pose_at(0.0, 0.0, 0.1 * std::sin(2.3 * time_s));
  };
  const TurnClock clock = turn_clock(poses_of(wandering, 60), imu_of(other, 6.0));
  ASSERT_TRUE(clock.is_known);
  EXPECT_LT(clock.explained_moved, 0.5);
}

TEST(TurnClock, KnowsNothingOfAStraightDriveOrAFewPosesOrAGap) {
  const VehicleMotion straight = [](double time_s) { return pose_at(8.0 * time_s, 0.0, 0.3); };
  const std::vector<TurnRate> rates = imu_of(wandering, 6.0);
  EXPECT_FALSE(turn_clock(poses_of(straight, 60, 0.0001), imu_of(straight, 6.0)).is_known);
  EXPECT_TRUE(turn_clock(poses_of(wandering, 40), rates).is_known);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 20), rates).is_known);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 60), {}).is_known);
  std::vector<TurnRate> seldom;
  for (std::size_t i = 0; i < rates.size(); i += 11) seldom.push_back(rates[i]);
  EXPECT_FALSE(turn_clock(poses_of(wandering, 60), seldom).is_known);
}

}  // namespace
}  // namespace sightline
