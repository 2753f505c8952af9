#include "passes/trajectory/pieces/wider_starts.h"

#include <gtest/gtest.h>

#include <numbers>

#include "formats/rotation.h"
#include "passes/trajectory/pieces/scan_overlap.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

Pose lidar_at(double x_m, double y_m, double yaw_rad) {
  Pose pose = pose_at(x_m, y_m, yaw_rad);
  pose.translation().z() = 2.0;
  return pose;
}

std::vector<Eigen::Vector3d> upright_seen(const BoxWorld& world, const Pose& T_map_lidar) {
  return upright_points(scan_world(world, T_map_lidar, 1.0).points_m, Eigen::Matrix3d::Identity());
}

std::vector<Eigen::Vector3d> in_map(const std::vector<Eigen::Vector3d>& points_m,
                                    const Pose& T_map_lidar) {
  std::vector<Eigen::Vector3d> moved_m;
  for (const Eigen::Vector3d& point_m : points_m) moved_m.push_back(T_map_lidar * point_m);
  return moved_m;
}

// Within a cell and what half a cell turns the farthest point by.
TEST(WiderStarts, FindsAScanThatTurnedAndWentOnUnseen) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const BoxWorld world = random_street(seed);
    const Pose before = lidar_at(0.0, 0.0, 0.1);
    const double yaw_rad = 1.3 * static_cast<double>(seed) - 2.0;
    const Pose truth = lidar_at(7.0, 1.0, yaw_rad);
    const std::vector<WiderStart> found = wider_starts(in_map(upright_seen(world, before), before),
                                                       upright_seen(world, truth), before, {});
    ASSERT_FALSE(found.empty()) << seed;
    const Pose off = truth.inverse() * found.front().T_map_lidar;
    EXPECT_LT(off.translation().norm(), 0.8) << seed;
    EXPECT_LT(rotation_angle_rad(off.linear()), 0.05) << seed;
  }
}

TEST(WiderStarts, ComeInOrderAndApartFromEachOther) {
  const BoxWorld world = random_street(9);
  const Pose at = lidar_at(0.0, 0.0, 0.0);
  WideSearch search;
  search.least_share = 0.15;
  const std::vector<Eigen::Vector3d> seen_m = upright_seen(world, at);
  const std::vector<WiderStart> found = wider_starts(in_map(seen_m, at), seen_m, at, search);
  ASSERT_GE(found.size(), 2u);
  EXPECT_GT(found.front().share, 0.95);
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_LE(found[i].share, found[i - 1].share);
    for (std::size_t j = 0; j < i; ++j) {
      const Pose between = found[i].T_map_lidar.inverse() * found[j].T_map_lidar;
      EXPECT_TRUE(between.translation().norm() > 1.4 ||
                  rotation_angle_rad(between.linear()) > 9.9 * std::numbers::pi / 180.0);
    }
  }
}

TEST(WiderStarts, FindNothingWhereNothingFits) {
  const Pose at = lidar_at(0.0, 0.0, 0.0);
  EXPECT_TRUE(wider_starts({}, upright_seen(random_street(1), at), at, {}).empty());
  EXPECT_TRUE(wider_starts({{1.0, 0.0, 1.0}}, {}, at, {}).empty());
}

}  // namespace
}  // namespace sightline
