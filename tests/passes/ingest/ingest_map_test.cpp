#include "passes/ingest/ingest_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/foreign/clouds/pcd_writer.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

using testing::HasSubstr;

std::vector<PointXyzi> ground(double from_m, double step_m) {
  std::vector<PointXyzi> points;
  for (double x_m = from_m + 0.5 * step_m; x_m < from_m + 16.0; x_m += step_m) {
    for (double y_m = 64.0 + 0.5 * step_m; y_m < 80.0; y_m += step_m) {
      points.push_back({static_cast<float>(x_m), static_cast<float>(y_m), 1.0F, 0.0F});
    }
  }
  return points;
}

class IngestMapTest : public testing::Test {
 protected:
  PointMap map_of_two(double step_m) {
    EXPECT_TRUE(write_pcd_binary(folder_ / "map/0.pcd", ground(128.0, step_m), IfExists::kReplace)
                    .has_value());
    EXPECT_TRUE(write_pcd_binary(folder_ / "map/1.pcd", ground(144.0, step_m), IfExists::kReplace)
                    .has_value());
    return *open_point_map(folder_ / "map", 1);
  }
  ScratchFolder folder_;
  TestContext ctx_;
};

TEST_F(IngestMapTest, PiecesMakeTheCellsOfThePointsThatTheyHold) {
  const SurfacePoints points = value_of(ingest_map(ctx_, {}, map_of_two(0.1)));
  ASSERT_TRUE(validate(points).has_value());
  EXPECT_THAT(ctx_.warnings, testing::IsEmpty());
  EXPECT_EQ(points.frame.origin_world_m, Eigen::Vector3d(128.0, 64.0, 0.0));
  EXPECT_EQ(points.standing_count, 2U * 160U * 160U);
  const NdtMap ndt = value_of(whole_rows(build_ndt(ctx_, {}, points)));
  EXPECT_EQ(ndt.nds.size(), 16U * 8U);
  EXPECT_EQ(ndt.point_count, points.standing_count);
  // No ray opens what was not looked through.
  EXPECT_GE(value_of(whole_rows(build_surface(ctx_, {}, points))).patches.size(), 64U * 32U);
  SurfacePoints cached = value_of(from_bytes<SurfacePoints>(to_bytes(points)));
  reattach(cached, map_of_two(0.1));
  EXPECT_EQ(to_bytes(*whole_rows(build_ndt(ctx_, {}, cached))), to_bytes(ndt));
}

TEST_F(IngestMapTest, SaysHowThinAMapIsAndWhatThatCosts) {
  ASSERT_TRUE(ingest_map(ctx_, {}, map_of_two(0.4)).has_value());
  ASSERT_EQ(ctx_.warnings.size(), 1U);
  EXPECT_THAT(ctx_.warnings[0], HasSubstr("6.2 points per square metre"));
  EXPECT_THAT(ctx_.warnings[0], HasSubstr("has gaps"));
  EXPECT_EQ(ctx_.warnings[0].find("are left out"), std::string::npos);
  ASSERT_TRUE(ingest_map(ctx_, {}, map_of_two(0.8)).has_value());
  EXPECT_THAT(ctx_.warnings[1], HasSubstr("are left out"));
}

TEST_F(IngestMapTest, RefusesAMapWiderThanAGrid) {
  const std::vector<PointXyzi> far = {{0.0F, 1.0F, 0.0F, 0.0F}, {3e9F, 1.0F, 0.0F, 0.0F}};
  ASSERT_TRUE(write_pcd_binary(folder_ / "far.pcd", far).has_value());
  EXPECT_EQ(failure_of(ingest_map(ctx_, {}, *open_point_map(folder_ / "far.pcd", 1))).code,
            ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
