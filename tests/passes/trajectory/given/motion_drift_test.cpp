#include "passes/trajectory/given/motion_drift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/base/units.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

Pose turn(double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.rotate(rotation_matrix({Eigen::Vector3d::UnitZ(), yaw_rad}));
  return pose;
}

// 200 m at 10 m/s, ten scans a second, matched to a centimetre.
class MotionDriftTest : public testing::Test {
 protected:
  static constexpr int kScans = 200;

  static Pose pose_at(double time_s, bool is_winding) {
    const double yaw_rad = is_winding ? 0.6 * std::sin(0.7 * time_s) : 0.0;
    return Eigen::Translation3d(10.0 * time_s, is_winding ? std::cos(0.7 * time_s) : 0.0, 0.0) *
           turn(yaw_rad);
  }
  // `late_s`: the poses are those of so long ago.
  void drive(bool is_winding, double late_s) {
    for (int i = 0; i < kScans; ++i) {
      ScanInfo& scan = drive_.scans.emplace_back();
      scan.recording_index = static_cast<std::uint32_t>(i);
      scan.stamp_ns = i * kSecond_ns / 10;
      scan.T_world_vehicle = pose_at(0.1 * i - late_s, is_winding);
      const double noise_m = i % 2 == 0 ? 0.0 : 0.01;
      odometry_.append(pose_at(0.1 * i, is_winding) * Eigen::Translation3d(noise_m, noise_m, 0.0),
                       i == 0 ? 0.0 : 1.0, true, {});
    }
  }
  [[nodiscard]] GivenPoses given() const {
    GivenPoses poses;
    for (const ScanInfo& scan : drive_.scans) poses.push_back(scan.T_world_vehicle);
    return poses;
  }
  void scale(double factor) {
    for (ScanInfo& scan : drive_.scans) scan.T_world_vehicle->translation() *= factor;
  }
  std::optional<ClockShift> shift() { return find_clock_shift(drive_, given(), odometry_); }
  std::vector<MotionDrift> drifts() {
    return find_drifts({.off_m = 1.5, .off_rad = 0.1}, given(), odometry_);
  }

  Drive drive_;
  Odometry odometry_;
};

TEST_F(MotionDriftTest, FindsTheClockOfPosesThatAreAScanLate) {
  drive(true, 0.1);
  ASSERT_TRUE(shift().has_value());
  EXPECT_EQ(shift()->ahead_ns, kSecond_ns / 10) << "poses of the scan before";
  EXPECT_THAT(to_text(*shift(), drive_), HasSubstr("0.10 s ahead of that of the scans"));
}

TEST_F(MotionDriftTest, PosesAtTheTimesOfTheScansByTheirClockAreRight) {
  drive(true, -0.27);
  ASSERT_TRUE(shift().has_value());
  EXPECT_NEAR(static_cast<double>(shift()->ahead_ns), -0.27e9, 0.01e9);
  const Drive moved = with_clock(drive_, *shift(), odometry_);
  for (int i = 0; i < kScans; ++i) {
    const Pose off = pose_at(0.1 * i, true).inverse() *
                     *moved.scans[static_cast<std::size_t>(i)].T_world_vehicle;
    EXPECT_LT(off.translation().norm(), 0.15) << i;
  }
}

TEST_F(MotionDriftTest, AcceptsTheScansOwnClockAndEvenMotion) {
  drive(true, 0.0);
  EXPECT_FALSE(shift().has_value());
  EXPECT_THAT(drifts(), IsEmpty());
  EXPECT_FALSE(find_scale_error(given(), odometry_).has_value());
}

TEST_F(MotionDriftTest, EvenMotionFitsAtAllTimes) {
  drive(false, 0.3);
  EXPECT_FALSE(shift().has_value());
}

TEST_F(MotionDriftTest, MeasuresAScaleOfOnePercent) {
  drive(true, 0.0);
  scale(1.01);
  const std::optional<double> error = find_scale_error(given(), odometry_);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(*error, 0.01, 0.001);
  EXPECT_THAT(drifts(), IsEmpty());
}

TEST_F(MotionDriftTest, StepsThatTheScansDoNotConstrainAreNotCompared) {
  drive(true, 0.0);
  scale(1.1);
  EXPECT_EQ(drifts().size(), 1U);
  for (StepConstraint& step : odometry_.constraint) step.weak = Eigen::Vector3d::UnitX();
  EXPECT_THAT(drifts(), IsEmpty());
  EXPECT_FALSE(find_scale_error(given(), odometry_).has_value());
}

TEST_F(MotionDriftTest, NamesAStretchWhereGivenPosesTurnMoreThanTheScans) {
  drive(false, 0.0);
  Pose bent = Pose::Identity();
  for (int i = 1; i < kScans; ++i) {
    bent = bent * Eigen::Translation3d(1.0, 0.0, 0.0) * turn(0.002);
    drive_.scans[static_cast<std::size_t>(i)].T_world_vehicle = bent;
  }
  ASSERT_FALSE(drifts().empty());
  EXPECT_NEAR(drifts().front().turn_rad, 0.2, 0.02);
  EXPECT_THAT(to_text(drifts().front(), drive_), HasSubstr("degrees farther round"));
}

TEST_F(MotionDriftTest, AFewSlipsOfTheMatchingAreNoDrift) {
  drive(true, 0.0);
  for (std::size_t i = 60; i < odometry_.T_map_lidar.size(); ++i) {
    odometry_.T_map_lidar[i].pretranslate(Eigen::Vector3d(8.0, 0.0, 0.0));
  }
  EXPECT_THAT(drifts(), IsEmpty());
  EXPECT_FALSE(find_scale_error(given(), odometry_).has_value());
  EXPECT_FALSE(shift().has_value());
}

}  // namespace
}  // namespace sightline
