#include "formats/surface_points.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

SurfacePoints three_points() {
  SurfacePoints points;
  points.frame.origin_world_m = {64.0, 0.0, 0.0};
  points.points_m = {{1.0, 2.0, 3.0}, {-4.0, 5.5, 6.0}};
  points.moving_m = {{7.0, 8.0, 9.0}};
  points.out_of_range_count = 12;
  points.voxel_m = 0.2;
  return points;
}

TEST(SurfacePoints, SurviveTheDisk) { expect_survives_disk(three_points()); }

TEST(SurfacePoints, ArePrintedWithWhatWasRemoved) {
  const Table table = dump(three_points());
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"x_m", "y_m", "z_m", "is_moving"}));
  EXPECT_EQ(table.rows[1][1], Cell(5.5));
  EXPECT_EQ(table.rows[1][3], Cell(std::int64_t{0}));
  EXPECT_EQ(table.rows[2][0], Cell(7.0));
  EXPECT_EQ(table.rows[2][3], Cell(std::int64_t{1}));
}

TEST(SurfacePoints, RefuseWhatIsNotFinite) {
  SurfacePoints standing = three_points();
  standing.points_m[1].z() = std::numeric_limits<double>::quiet_NaN();
  ASSERT_FALSE(validate(standing).has_value());
  EXPECT_EQ(validate(standing).error().place, "standing point 1");
  SurfacePoints moving = three_points();
  moving.moving_m[0].x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(validate(moving).has_value());
  SurfacePoints voxel = three_points();
  voxel.voxel_m = -0.2;
  EXPECT_FALSE(validate(voxel).has_value());
}

}  // namespace
}  // namespace sightline
