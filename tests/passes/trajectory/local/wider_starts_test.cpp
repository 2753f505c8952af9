#include "passes/trajectory/local/wider_starts.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "formats/base/random.h"
#include "formats/geometry.h"
#include "passes/trajectory/local/local_map.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

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
    const Pose truth = lidar_at(7.0, 1.0, 1.3 * static_cast<double>(seed) - 2.0);
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

using Cells = std::set<std::array<int, 3>>;

int cell_of(double x_m) { return static_cast<int>(std::floor(x_m / 0.5)); }
int layer_of(double z_m) { return std::clamp(static_cast<int>(std::floor(z_m + 3.0)), 0, 7); }

// The cells and layers that points of a map count for: within half of each.
Cells cells_of(const std::vector<Eigen::Vector3d>& points_m) {
  Cells cells;
  for (const Eigen::Vector3d& point_m : points_m) {
    for (const double dx_m : {-0.125, 0.125}) {
      for (const double dy_m : {-0.125, 0.125}) {
        for (const double dz_m : {-0.5, 0.5}) {
          cells.insert({cell_of(point_m.x() + dx_m), cell_of(point_m.y() + dy_m),
                        layer_of(point_m.z() + dz_m)});
        }
      }
    }
  }
  return cells;
}

double share_at(const Cells& cells, const std::vector<Eigen::Vector3d>& scan_m, int heading, int x,
                int y) {
  const Eigen::Matrix3d turn =
      rotation_matrix({Eigen::Vector3d::UnitZ(), 2.0 * std::numbers::pi * heading / 504.0});
  std::size_t met = 0;
  for (const Eigen::Vector3d& point_m : scan_m) {
    const Eigen::Vector3d turned_m = turn * point_m;
    met +=
        cells.count({cell_of(turned_m.x()) + x, cell_of(turned_m.y()) + y, layer_of(turned_m.z())});
  }
  return static_cast<double>(met) / static_cast<double>(scan_m.size());
}

// Points in cells of their own, up to so far away.
std::vector<Eigen::Vector3d> scattered(std::size_t count, double reach_m, Random& random) {
  std::set<std::array<int, 2>> taken;
  std::vector<Eigen::Vector3d> points_m;
  while (points_m.size() < count) {
    const Eigen::Vector3d point_m(random.uniform(-reach_m, reach_m),
                                  random.uniform(-reach_m, reach_m), random.uniform(-3.5, 5.5));
    if (taken.insert({cell_of(point_m.x()), cell_of(point_m.y())}).second) {
      points_m.push_back(point_m);
    }
  }
  return points_m;
}

TEST(WiderStarts, AreTheBestOfAllPlacesAndHeadings) {
  for (const double reach_m : {1.0, 3.7}) {
    Random random(7);
    const std::vector<Eigen::Vector3d> scan_m = scattered(40, 6.0, random);
    const std::vector<Eigen::Vector3d> map_m = scattered(300, 9.0, random);
    const Cells cells = cells_of(map_m);
    WideSearch search;
    search.reach_m = reach_m;
    search.least_share = 0.1;
    const std::vector<WiderStart> found = wider_starts(map_m, scan_m, Pose::Identity(), search);
    ASSERT_FALSE(found.empty());
    const int reach = static_cast<int>(std::ceil(reach_m / 0.5));
    double best = 0.0;
    for (int heading = 0; heading < 504; ++heading) {
      for (int x = -reach; x <= reach; ++x) {
        for (int y = -reach; y <= reach; ++y) {
          best = std::max(best, share_at(cells, scan_m, heading, x, y));
        }
      }
    }
    EXPECT_EQ(found.front().share, best);
    for (const WiderStart& start : found) {
      const double yaw_rad = std::atan2(start.T_map_lidar(1, 0), start.T_map_lidar(0, 0));
      const int turn = static_cast<int>(std::lround(yaw_rad * 504.0 / (2.0 * std::numbers::pi)));
      const int heading = turn < 0 ? turn + 504 : turn;
      const Eigen::Vector3d at_m = start.T_map_lidar.translation();
      EXPECT_EQ(start.share,
                share_at(cells, scan_m, heading, cell_of(at_m.x()), cell_of(at_m.y())));
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
