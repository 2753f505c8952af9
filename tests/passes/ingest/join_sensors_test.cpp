#include "passes/ingest/join_sensors.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "passes/trajectory/complete_trajectory.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

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
  const Result<Drive> joined = join_sensors(TestContext(), {}, front, {{&rear}});
  ASSERT_FALSE(joined.has_value());
  EXPECT_EQ(joined.error().code, ErrorCode::kMismatchedInputs);
  EXPECT_NE(joined.error().message.find("one clock"), std::string::npos);
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
