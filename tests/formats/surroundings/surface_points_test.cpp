#include "formats/surroundings/surface_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/base/random.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Two made points; a recorded scan of three, one metre up: one too near, one in a voxel that moved.
SurfacePoints few_points() {
  SurfacePoints points;
  points.frame.origin_world_m = {64.0, 0.0, 0.0};
  points.points_m = {{1.0, 2.0, 3.0}, {-4.0, 5.5, 6.0}};
  Pose T_map_lidar = Pose::Identity();
  T_map_lidar.translation().z() = 1.0;
  points.scans = {{0, T_map_lidar, 0.5, 100.0}};
  points.moved_voxels = {{-30, 2, 2}, {35, 0, 5}};
  points.standing_count = 1;
  points.moving_count = 1;
  points.out_of_range_count = 1;
  points.voxel_m = 0.2;
  Scan scan;
  scan.points_m = {{7.1, 0.1, 0.1}, {7.1, 0.3, 0.1}, {0.1, 0.1, 0.0}};
  points.store = memory_scan_store({scan});
  return points;
}

TEST(SurfacePoints, SurviveTheDisk) { expect_survives_disk(few_points()); }

TEST(SurfacePoints, AreReadScanByScanWithoutWhatMoved) {
  const SurfacePoints points = few_points();
  const SurfacePointReader reader(points);
  ASSERT_EQ(reader.part_count(), 2u);
  const std::vector<Eigen::Vector3d> standing = value_of(reader.standing(0));
  ASSERT_EQ(standing.size(), 1u);
  EXPECT_LT((standing[0] - Eigen::Vector3d(7.1, 0.3, 1.1)).norm(), 1e-12);
  const std::vector<Eigen::Vector3d> moving = value_of(reader.moving(0));
  ASSERT_EQ(moving.size(), 1u);
  EXPECT_LT((moving[0] - Eigen::Vector3d(7.1, 0.1, 1.1)).norm(), 1e-12);
  EXPECT_EQ(*reader.standing(1), points.points_m);
  EXPECT_TRUE(reader.moving(1)->empty());
}

TEST(SurfacePoints, BelongToTheMapUpToBothRangesToTheBit) {
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d point_m(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), 1.0);
    double range_m = point_m.norm();
    if (i % 3 == 1) range_m = std::nextafter(range_m, 0.0);
    if (i % 3 == 2) range_m = std::nextafter(range_m, 100.0);
    SurfacePoints points;
    Scan scan;
    scan.points_m = {point_m, {40.0, 0.0, 0.0}};
    points.scans = {{0, Pose::Identity(), range_m, 90.0}, {0, Pose::Identity(), 0.1, range_m}};
    points.store = memory_scan_store({scan});
    const SurfacePointReader reader(points);
    const bool is_far_enough = point_m.norm() >= range_m;
    const bool is_near_enough = point_m.norm() <= range_m;
    EXPECT_EQ(reader.standing(0)->size(), is_far_enough ? 2U : 1U);
    EXPECT_EQ(reader.standing(1)->size(), is_near_enough ? 1U : 0U);
  }
}

TEST(SurfacePoints, FindEveryVoxelThatMovedAndNoOther) {
  Random random(5);
  SurfacePoints points;
  points.voxel_m = 1.0;
  Scan scan;
  for (int x = -9; x < 9; ++x) {
    for (int y = -9; y < 9; ++y) {
      for (int z = -2; z < 2; ++z) {
        scan.points_m.emplace_back(x + 0.5, y + 0.5, z + 0.5);
        if (random.uniform() < 0.3) points.moved_voxels.push_back({x, y, z});
      }
    }
  }
  points.scans = {{0, Pose::Identity(), 0.0, 100.0}};
  points.store = memory_scan_store({scan});
  ASSERT_TRUE(validate(points).has_value());
  const SurfacePointReader reader(points);
  const std::vector<Eigen::Vector3d> moving = value_of(reader.moving(0));
  ASSERT_EQ(moving.size(), points.moved_voxels.size());
  for (std::size_t i = 0; i < moving.size(); ++i) {
    EXPECT_EQ(cell_key(moving[i], 1.0), points.moved_voxels[i]);
  }
  EXPECT_EQ(reader.standing(0)->size(), scan.points_m.size() - moving.size());
  const ReturnsInMap all = value_of(reader.all(0));
  EXPECT_EQ(all.points_m, scan.points_m);
  ASSERT_EQ(all.has_moved.size(), scan.points_m.size());
  for (std::size_t i = 0; i < scan.points_m.size(); ++i) {
    const CellKey voxel = cell_key(scan.points_m[i], 1.0);
    EXPECT_EQ(all.has_moved[i] != 0, std::ranges::binary_search(points.moved_voxels, voxel));
  }
}

TEST(SurfacePoints, ArePrintedWithWhatWasRemoved) {
  const Table table = dump(few_points());
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"x_m", "y_m", "z_m", "is_moving"}));
  EXPECT_EQ(table.rows[1][1], Cell(5.5));
  EXPECT_EQ(table.rows[1][3], Cell(std::int64_t{0}));
  EXPECT_NEAR(std::get<double>(table.rows[2][0]), -5.9, 1e-12);
  EXPECT_EQ(table.rows[2][3], Cell(std::int64_t{1}));
}

TEST(SurfacePoints, RefuseWhatMakesNoSense) {
  SurfacePoints standing = few_points();
  standing.points_m[1].z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(failure_of(validate(standing)).place, "standing point 1");
  expect_refused<SurfacePoints>(
      few_points(),
      {[](SurfacePoints& voxel) { voxel.voxel_m = -0.2; },
       [](SurfacePoints& points) { std::swap(points.moved_voxels[0], points.moved_voxels[1]); },
       [](SurfacePoints& turned) { turned.scans[0].T_map_lidar.linear() *= 2.0; },
       [](SurfacePoints& ranges) { ranges.scans[0].max_range_m = 0.1; }});
}

}  // namespace
}  // namespace sightline
