#include "passes/map/count_removed.h"

#include <gtest/gtest.h>

#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Scans of four returns, 1 m apart; the first of each lies in a voxel that was removed if its scan
// is before 10 m.
SurfacePoints street() {
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  SurfacePoints points;
  points.voxel_m = 0.2;
  for (std::uint32_t i = 0; i < 21; ++i) {
    Scan scan;
    for (int k = 0; k < 4; ++k) scan.points_m.push_back({0.1, 5.1 + k, 0.1});
    scans.push_back(scan);
    poses.push_back(Pose(Eigen::Translation3d(i, 0.0, 0.0)));
    points.scans.push_back({i, poses.back(), 1.0, 100.0});
    if (i < 10) points.moved_voxels.push_back(cell_key(poses.back() * scan.points_m[0], 0.2));
  }
  std::ranges::sort(points.moved_voxels);
  points.store = drive_of(scans, poses).drive.store;
  return points;
}

TEST(CountRemoved, PoolsTheScansAroundASite) {
  Sites sites;
  for (const double x_m : {0.0, 10.0, 20.0, 500.0}) {
    Site site;
    site.p_map_m.x() = x_m;
    sites.sites.push_back(site);
  }
  const SiteColumn column = value_of(count_removed(TestContext(2), {}, street(), sites));
  EXPECT_TRUE(validate(column).has_value());
  EXPECT_EQ(column.name, kRemovedShare);
  ASSERT_EQ(column.values.size(), 4U);
  EXPECT_FLOAT_EQ(column.values[0], 0.25F);  // of scans at 0, 2 and 4 m
  // Of those at 6, 8, 10, 12 and 14 m two have a removed return.
  EXPECT_FLOAT_EQ(column.values[1], 0.1F);
  EXPECT_FLOAT_EQ(column.values[2], 0.0F);
  EXPECT_TRUE(std::isinf(column.values[3]));
}

TEST(CountRemoved, IsNoneWhereNothingIsRemoved) {
  SurfacePoints points = street();
  points.moved_voxels.clear();
  Sites sites;
  sites.sites.emplace_back();
  EXPECT_EQ(value_of(count_removed(TestContext(), {}, points, sites)).values.at(0), 0.0F);
}

}  // namespace
}  // namespace sightline
