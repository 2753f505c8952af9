#include "passes/trajectory/local/scan_overlap.h"

#include <gtest/gtest.h>

#include "tests/support/box_world.h"

namespace sightline {
namespace {

const Eigen::Matrix3d kLevel = Eigen::Matrix3d::Identity();

// A wall along x at y = 5 m, a point every 0.25 m and 0.5 m of height; and the ground before it.
std::vector<Eigen::Vector3d> wall_and_ground() {
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 4; ++j) points_m.emplace_back(0.05 + 0.25 * i, 5.05, 0.3 + 0.5 * j);
    for (int j = 0; j < 8; ++j) points_m.emplace_back(0.05 + 0.25 * i, 0.05 + 0.5 * j, 0.0);
  }
  return points_m;
}

TEST(ScanOverlap, CountsWhatStandsAndNotTheGround) {
  const std::vector<Eigen::Vector3d> upright_m = upright_points(wall_and_ground(), kLevel);
  ASSERT_EQ(upright_m.size(), 160u);
  for (const Eigen::Vector3d& point_m : upright_m) EXPECT_EQ(point_m.y(), 5.05);
}

TEST(ScanOverlap, LevelsTheScanOfATiltedSensor) {
  const Eigen::Matrix3d tilt = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()).toRotationMatrix();
  std::vector<Eigen::Vector3d> tilted_m;
  for (const Eigen::Vector3d& point_m : wall_and_ground()) {
    tilted_m.push_back(tilt.transpose() * point_m);
  }
  EXPECT_LT(upright_points(tilted_m, kLevel).size(), 100u);  // the wall leans
  EXPECT_EQ(upright_points(tilted_m, tilt).size(), 160u);
}

// Half of a wall of 10 m moved along itself by 5 m meets it; moved off by 0.6 m nothing does.
TEST(ScanOverlap, IsTheShareThatMeetsTheMap) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  EXPECT_FALSE(map.overlap(wall_m, Pose::Identity()).has_value());
  map.add(wall_m, Pose::Identity(), 0.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 1.0);
  EXPECT_NEAR(*map.overlap(wall_m, pose_at(5.0, 0.0, 0.0)), 0.5, 0.03);
  EXPECT_EQ(*map.overlap(wall_m, pose_at(0.0, 0.6, 0.0)), 0.0);
}

TEST(ScanOverlap, IsNoneForAHandfulOfReturns) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  map.add(wall_m, Pose::Identity(), 0.0);
  const std::vector<Eigen::Vector3d> few_m(wall_m.begin(), wall_m.begin() + 29);
  EXPECT_FALSE(map.overlap(few_m, Pose::Identity()).has_value());
}

TEST(ScanOverlap, ForgetsWhatWasSeenTooLongAgo) {
  const std::vector<Eigen::Vector3d> wall_m = upright_points(wall_and_ground(), kLevel);
  UprightMap map(50.0);
  map.add(wall_m, Pose::Identity(), 0.0);
  map.add(wall_m, pose_at(49.0, 0.0, 0.0), 49.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 1.0);
  map.add(wall_m, pose_at(60.0, 0.0, 0.0), 60.0);
  EXPECT_EQ(*map.overlap(wall_m, Pose::Identity()), 0.0);
  EXPECT_EQ(map.points_m().size(), 2 * wall_m.size());
}

}  // namespace
}  // namespace sightline
