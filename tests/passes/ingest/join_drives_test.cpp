#include "passes/ingest/join_drives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/base/units.h"
#include "passes/trajectory/complete_trajectory.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;
constexpr std::int64_t kMonday_ns = 1'700'000'000 * kSecond_ns;
constexpr std::int64_t kDay_ns = 86'400 * kSecond_ns;

// A drive whose scan k, one a second from `begin_ns` on, holds the one point (k, x, 0).
Drive day(const std::string& name, std::int64_t begin_ns, int count, double x) {
  Drive drive;
  drive.name = name;
  drive.sensor.beam_elevations_deg = {-1.0, 1.0};
  std::vector<Scan> scans;
  for (int k = 0; k < count; ++k) {
    ScanInfo& info = drive.scans.emplace_back();
    info.recording_index = static_cast<std::uint32_t>(k);
    info.stamp_ns = begin_ns + k * kSecond_ns;
    info.point_count = 1;
    scans.push_back({info.stamp_ns, {Eigen::Vector3d(k, x, 0.0)}});
  }
  return with_store(drive, memory_scan_store(std::move(scans)));
}

struct Joined {
  Drive drive;
  std::vector<std::string> warnings;
};

Joined join(const Drive& first, const Drive& later) {
  TestContext ctx;
  Drive drive = value_of(join_drives(ctx, {}, first, {{&later}}));
  EXPECT_TRUE(validate(drive).has_value());
  return {std::move(drive), ctx.warnings};
}

TEST(JoinDrives, PutsOneBehindTheOtherAndKeepsWhatIsEven) {
  const Joined joined =
      join(day("monday", kMonday_ns, 3, 1.0), day("tuesday", kMonday_ns + kDay_ns, 2, 2.0));
  EXPECT_TRUE(joined.warnings.empty());
  EXPECT_EQ(joined.drive.name, "monday");
  EXPECT_EQ(joined.drive.later_parts, std::vector<std::string>{"tuesday"});
  EXPECT_EQ(joined.drive.names_of_parts(), "monday, tuesday");
  ASSERT_EQ(joined.drive.scans.size(), 5U);
  const std::vector<std::uint32_t> indices = {0, 1, 2, 4, 5};
  for (std::size_t i = 0; i < 5; ++i) {
    const bool is_later = i >= 3;
    const ScanInfo& scan = joined.drive.scans[i];
    EXPECT_EQ(scan.recording_index, indices[i]);
    EXPECT_EQ(scan.part, is_later ? 1U : 0U);
    EXPECT_EQ(joined.drive.name_of_part(scan.part), is_later ? "tuesday" : "monday");
    const Result<Scan> read = joined.drive.store->read(i);
    EXPECT_EQ(read->points_m.at(0),
              Eigen::Vector3d(is_later ? static_cast<double>(i - 3) : static_cast<double>(i),
                              is_later ? 2.0 : 1.0, 0.0));
    EXPECT_EQ(read->stamp_ns, scan.stamp_ns);
  }
  EXPECT_EQ(joined.drive.scans[3].stamp_ns, kMonday_ns + kDay_ns) << "true times stay";
}

TEST(JoinDrives, KeepsTheTurnRatesOfEachPartAndMovesThemWithIt) {
  Drive first = day("a", 0, 3, 1.0);
  Drive later = day("b", 0, 3, 2.0);
  later.turn_rates = {{-5, Eigen::Vector3d(1, 2, 3)}, {kSecond_ns, Eigen::Vector3d(4, 5, 6)}};
  later.wheel_speeds = {{7, 2.0}};
  later.specific_forces = {{9, Eigen::Vector3d(0, 0, 9.8)}};
  const Joined one = join(first, later);
  const std::int64_t later_ns = one.drive.scans[3].stamp_ns;
  ASSERT_EQ(one.drive.wheel_speeds.size(), 1U);
  EXPECT_EQ(one.drive.wheel_speeds[0].stamp_ns, later_ns + 7);
  ASSERT_EQ(one.drive.specific_forces.size(), 1U);
  EXPECT_EQ(one.drive.specific_forces[0].stamp_ns, later_ns + 9);
  ASSERT_EQ(one.drive.turn_rates.size(), 2U);
  EXPECT_EQ(one.drive.turn_rates[0].stamp_ns, later_ns - 5);
  EXPECT_EQ(one.drive.turn_rates[1].stamp_ns, later_ns + kSecond_ns);
  EXPECT_EQ(one.drive.turn_rates[1].rate_rad_per_s, Eigen::Vector3d(4, 5, 6));
  first.turn_rates = {{3 * kSecond_ns, Eigen::Vector3d(7, 8, 9)}};
  const Joined both = join(first, later);
  ASSERT_EQ(both.drive.turn_rates.size(), 3U);
  EXPECT_EQ(both.drive.turn_rates[0].stamp_ns, 3 * kSecond_ns);
}

TEST(JoinDrives, MovesTimesThatOverlapAndSaysSoOfAClock) {
  const Joined counted = join(day("a", 0, 3, 1.0), day("b", 0, 3, 2.0));
  EXPECT_TRUE(counted.warnings.empty()) << "times from 0 on are no clock's";
  EXPECT_EQ(counted.drive.scans[3].stamp_ns, 2 * kSecond_ns + kPauseBetweenParts_ns);
  EXPECT_EQ(counted.drive.scans[4].stamp_ns, 3 * kSecond_ns + kPauseBetweenParts_ns);
  EXPECT_EQ(counted.drive.store->read(4)->stamp_ns, counted.drive.scans[4].stamp_ns);
  const Joined wrong =
      join(day("monday", kMonday_ns, 3, 1.0), day("tuesday", kMonday_ns - 3600 * kSecond_ns, 3, 2));
  ASSERT_EQ(wrong.warnings.size(), 1U);
  EXPECT_THAT(wrong.warnings[0], HasSubstr("drive tuesday begins at"));
  EXPECT_THAT(wrong.warnings[0], HasSubstr("moved by 3662"));
}

TEST(JoinDrives, LeavesOutADriveOfAnotherSensorByName) {
  const Drive first = day("monday", 0, 3, 1.0);
  Drive other = day("tuesday", 0, 3, 2.0);
  other.sensor.name = "hdl-64e";
  const Joined joined = join(first, other);
  EXPECT_EQ(joined.drive.scans.size(), 3U);
  ASSERT_EQ(joined.warnings.size(), 1U);
  EXPECT_THAT(joined.warnings[0], HasSubstr("drive tuesday is left out: its sensor is hdl-64e"));
  Drive moved = day("tuesday", 0, 3, 2.0);
  moved.sensor.T_vehicle_lidar.translation().x() = 1.0;
  EXPECT_EQ(join(first, moved).drive.scans.size(), 3U);
}

TEST(JoinDrives, TakesTheFrameOfTheFirstThatHasPoses) {
  Drive with_poses = day("tuesday", 0, 2, 2.0);
  with_poses.frame.origin_world_m = Eigen::Vector3d(100.0, 200.0, 0.0);
  for (ScanInfo& scan : with_poses.scans) scan.T_world_vehicle = Pose::Identity();
  EXPECT_EQ(join(day("monday", 0, 2, 1.0), with_poses).drive.frame.origin_world_m.x(), 100.0);
  Drive first = with_poses;
  first.frame.origin_world_m.x() = 7.0;
  EXPECT_EQ(join(first, with_poses).drive.frame.origin_world_m.x(), 7.0);
}

TEST(JoinDrives, ChainsOfRandomDrivesAreDrivesThatSurviveAFile) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    const Drive first = day("0", static_cast<std::int64_t>(random.below(1000)) * kSecond_ns,
                            1 + static_cast<int>(random.below(5)), 0.0);
    Drive all = first;
    std::vector<Drive> others;
    std::size_t scans = all.scans.size();
    for (int later = 1; later < 4; ++later) {
      const Drive next =
          day(std::to_string(later), static_cast<std::int64_t>(random.below(1000)) * kSecond_ns,
              static_cast<int>(random.below(5)), later);
      scans += next.scans.size();
      all = join(all, next).drive;
      others.push_back(next);
    }
    ASSERT_EQ(all.scans.size(), scans);
    const Drive at_once =
        value_of(join_drives(TestContext(), {}, first, {{&others[0], &others[1], &others[2]}}));
    ASSERT_EQ(to_bytes(at_once), to_bytes(all));
    ASSERT_EQ(to_bytes(value_of(from_bytes<Drive>(to_bytes(all)))), to_bytes(all));
    for (std::size_t i = 0; i < scans; ++i) {
      const Result<Scan> scan = all.store->read(i);
      ASSERT_EQ(std::to_string(static_cast<int>(scan->points_m[0].y())),
                all.name_of_part(all.scans[i].part).substr(0, 1));
    }
  }
}

constexpr std::int64_t kMs_ns = 1'000'000;

// A drive of one sensor whose scan k, at stamps_ms[k], holds the one point (k, x, 0).
Drive one_sensor(const std::string& name, const std::vector<std::int64_t>& stamps_ms, double x) {
  Drive drive;
  drive.name = name;
  drive.sensor.name = name;
  drive.sensor.beam_elevations_deg = {-1.0, 1.0};
  drive.sensor.T_vehicle_lidar.translation().x() = x;
  std::vector<Scan> scans;
  for (const std::int64_t stamp_ms : stamps_ms) {
    const auto index = static_cast<std::uint32_t>(scans.size());
    ScanInfo& info = drive.scans.emplace_back();
    info.recording_index = index;
    info.stamp_ns = stamp_ms * kMs_ns;
    info.point_count = 1;
    scans.push_back({info.stamp_ns, {Eigen::Vector3d(index, x, 0.0)}});
  }
  return with_store(drive, memory_scan_store(std::move(scans)));
}

// Poses of all scans of the first sensor: 10 m/s along x, turning evenly.
Trajectory trajectory_of(const Drive& drive) {
  Trajectory trajectory;
  for (const ScanInfo& scan : drive.scans) {
    if (scan.sensor_index != 0) continue;
    TrajectoryPose& pose = trajectory.poses.emplace_back();
    pose.recording_index = scan.recording_index;
    pose.stamp_ns = scan.stamp_ns;
    const double time_s = 1e-9 * static_cast<double>(scan.stamp_ns);
    pose.T_map_vehicle.translation().x() = 10.0 * time_s;
    pose.T_map_vehicle.rotate(Eigen::AngleAxisd(0.3 * time_s, Eigen::Vector3d::UnitZ()));
  }
  return trajectory;
}

TEST(JoinSensors, KeepsTurnRatesOfTheFirstElseOfTheOther) {
  Drive front = one_sensor("front", {0, 100, 200}, 1.0);
  Drive rear = one_sensor("rear", {40, 150}, -1.0);
  rear.turn_rates = {{5, Eigen::Vector3d(1, 2, 3)}};
  const Drive others = value_of(join_sensors(TestContext(), {}, front, {{&rear}}));
  ASSERT_EQ(others.turn_rates.size(), 1U);
  EXPECT_EQ(others.turn_rates[0].stamp_ns, 5);
  front.turn_rates = {{7, Eigen::Vector3d(4, 5, 6)}};
  const Drive own = value_of(join_sensors(TestContext(), {}, front, {{&rear}}));
  ASSERT_EQ(own.turn_rates.size(), 1U);
  EXPECT_EQ(own.turn_rates[0].stamp_ns, 7);
}

TEST(JoinSensors, PutsScansInOrderOfTimeAndKeepsWhoseTheyAre) {
  const Drive front = one_sensor("front", {0, 100, 200}, 1.0);
  const Drive rear = one_sensor("rear", {40, 100, 150, 260}, -1.0);
  TestContext ctx;
  const Drive joined = value_of(join_sensors(ctx, {}, front, {{&rear}}));
  ASSERT_TRUE(validate(joined).has_value());
  ASSERT_EQ(joined.scans.size(), 6U);
  const std::vector<std::int64_t> stamps_ms = {0, 40, 100, 100, 150, 200};
  const std::vector<std::uint32_t> sensors = {0, 1, 0, 1, 1, 0};
  const std::vector<std::uint32_t> indices = {0, 0, 1, 1, 2, 2};  // each sensor's own
  for (std::size_t i = 0; i < 6; ++i) {
    const ScanInfo& scan = joined.scans[i];
    EXPECT_EQ(scan.stamp_ns, stamps_ms[i] * kMs_ns);
    EXPECT_EQ(scan.sensor_index, sensors[i]);
    EXPECT_EQ(scan.recording_index % 2, indices[i] % 2) << "even scans stay even";
    EXPECT_EQ(joined.sensor_of(scan).name, sensors[i] == 0 ? "front" : "rear");
    EXPECT_EQ(joined.store->read(i)->points_m.at(0),
              Eigen::Vector3d(indices[i], sensors[i] == 0 ? 1.0 : -1.0, 0.0));
  }
  ASSERT_EQ(ctx.warnings.size(), 1U);
  EXPECT_NE(ctx.warnings[0].find("1 of 4 scans of sensor rear are not between"), std::string::npos);
}

TEST(JoinSensors, TakesAThirdSensorAndLeavesOutScansInAGap) {
  const Drive front = one_sensor("front", {0, 100, 5000, 5100}, 1.0);
  const Drive rear = one_sensor("rear", {50, 5050}, 2.0);
  const Drive roof = one_sensor("roof", {50, 2500, 5000}, 3.0);
  const Drive three = value_of(join_sensors(TestContext(), {}, front, {{&rear, &roof}}));
  ASSERT_TRUE(validate(three).has_value());
  ASSERT_EQ(three.scans.size(), 8U);
  EXPECT_EQ(three.other_sensors.at(1).name, "roof");
  EXPECT_EQ(three.scans[2].sensor_index, 2U);  // roof at 50 ms, behind rear
  EXPECT_EQ(three.store->read(2)->points_m.at(0), Eigen::Vector3d(0.0, 3.0, 0.0));
}

TEST(JoinSensors, RefusesClocksWithoutCommonTime) {
  const Drive front = one_sensor("front", {0, 100}, 1.0);
  const Drive rear = one_sensor("rear", {1'000'000, 1'000'100}, 2.0);
  const Error refused = failure_of(join_sensors(TestContext(), {}, front, {{&rear}}));
  EXPECT_EQ(refused.code, ErrorCode::kMismatchedInputs);
  EXPECT_NE(refused.message.find("the same clock"), std::string::npos);
}

TEST(CompleteTrajectory, InterpolatesTheScansOfOtherSensorsAtTheirTimes) {
  Random random(5);
  std::vector<std::int64_t> front_ms;
  std::vector<std::int64_t> rear_ms;
  for (std::int64_t k = 0; k < 40; ++k) {
    front_ms.push_back(100 * k);
    rear_ms.push_back(100 * k + static_cast<std::int64_t>(random.below(90)));
  }
  const Drive front = one_sensor("front", front_ms, 1.0);
  const Drive rear = one_sensor("rear", rear_ms, -1.0);
  const Drive joined = value_of(join_sensors(TestContext(), {}, front, {{&rear}}));
  const Trajectory complete =
      value_of(complete_trajectory(TestContext(), {}, joined, trajectory_of(front)));
  ASSERT_TRUE(validate(complete).has_value());
  ASSERT_EQ(complete.poses.size(), joined.scans.size());
  for (std::size_t i = 0; i < joined.scans.size(); ++i) {
    const TrajectoryPose& pose = complete.poses[i];
    EXPECT_EQ(pose.recording_index, joined.scans[i].recording_index);
    EXPECT_EQ(pose.stamp_ns, joined.scans[i].stamp_ns);
    const double time_s = 1e-9 * static_cast<double>(pose.stamp_ns);
    EXPECT_NEAR(pose.T_map_vehicle.translation().x(), 10.0 * time_s, 1e-9);
    EXPECT_NEAR(Eigen::AngleAxisd(pose.T_map_vehicle.linear()).angle(), 0.3 * time_s, 1e-9);
  }
}

TEST(CompleteTrajectory, RefusesATrajectoryOfAnotherDrive) {
  const Drive front = one_sensor("front", {0, 100, 200}, 1.0);
  const Drive rear = one_sensor("rear", {40}, -1.0);
  const Drive joined = value_of(join_sensors(TestContext(), {}, front, {{&rear}}));
  std::vector<Trajectory> wrong(3, trajectory_of(front));
  wrong[0].poses.pop_back();
  wrong[1].poses[1].stamp_ns += 1;
  wrong[2].poses.push_back(wrong[2].poses.back());
  for (const Trajectory& trajectory : wrong) {
    EXPECT_EQ(failure_of(complete_trajectory(TestContext(), {}, joined, trajectory)).code,
              ErrorCode::kMismatchedInputs);
  }
}

}  // namespace
}  // namespace sightline
