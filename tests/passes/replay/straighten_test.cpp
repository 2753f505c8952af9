#include "passes/replay/straighten.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

Pose turned(double forward_m, double yaw_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation().x() = forward_m;
  return pose;
}

TEST(Straighten, PutsPointsWhereTheyWereAtTheStamp) {
  const VehicleMotion motion = {turned(2.0, 0.1), 100'000'000};  // 20 m/s, 1 rad/s
  Pose T_vehicle_sensor = turned(1.0, -0.3);
  T_vehicle_sensor.translation().z() = 1.8;
  Random random(3);
  Scan scan;
  std::vector<Eigen::Vector3d> expected_m;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d at_stamp_m(random.uniform(-35, 35), random.uniform(-35, 35), 1.0);
    const auto offset_ns = static_cast<std::int32_t>(random.uniform(-5e7, 5e7));
    const Pose moved = predicted_pose(Pose::Identity(), motion.T_before_after, offset_ns / 1e8);
    expected_m.push_back(at_stamp_m);
    scan.points_m.push_back((moved * T_vehicle_sensor).inverse() * (T_vehicle_sensor * at_stamp_m));
    scan.time_offset_ns.push_back(offset_ns);
  }
  straighten(scan, motion, T_vehicle_sensor);
  EXPECT_TRUE(scan.time_offset_ns.empty());
  for (std::size_t i = 0; i < expected_m.size(); ++i) {
    EXPECT_LT((scan.points_m[i] - expected_m[i]).norm(), 1e-4) << i;
  }
}

TEST(Straighten, LeavesScansWithoutTimesOrMotion) {
  const VehicleMotion motion = {turned(2.0, 0.1), 100'000'000};
  Scan scan{0, {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}}, {}};
  straighten(scan, motion, Pose::Identity());
  EXPECT_EQ(scan.points_m[1], Eigen::Vector3d(4.0, 5.0, 6.0));
  scan.time_offset_ns = {0, 90'000'000};
  straighten(scan, VehicleMotion{}, Pose::Identity());
  EXPECT_EQ(scan.points_m[1], Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_TRUE(scan.time_offset_ns.empty());
  scan.time_offset_ns = {0, 0};  // all at once, and so at the stamp
  straighten(scan, motion, Pose::Identity());
  EXPECT_EQ(scan.points_m[1], Eigen::Vector3d(4.0, 5.0, 6.0));
}

}  // namespace
}  // namespace sightline
