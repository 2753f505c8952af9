#include "passes/ingest/ingest_nd_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;

ForeignNd nd_at(const CellKey& key, std::uint32_t point_count) {
  ForeignNd nd{key, point_count, {0.25, 0.5, 0.75}, Eigen::Matrix3d::Zero()};
  nd.covariance_m2.diagonal() = Eigen::Vector3d(0.03, 0.02, 0.01);
  return nd;
}

ForeignNds map_of(std::vector<ForeignNd> nds) {
  ForeignNds map;
  map.name = "theirs";
  map.world = "utm:10N";
  map.cell_m = 1.0;
  map.nds = std::move(nds);
  for (const ForeignNd& nd : map.nds) map.point_count += nd.point_count;
  return map;
}

class IngestNdMapTest : public testing::Test {
 protected:
  TestContext ctx_;
};

TEST_F(IngestNdMapTest, LaysNdsIntoAFrameNearThem) {
  const NdtMap map = value_of(ingest_nd_map(
      ctx_, {}, map_of({nd_at({588290, 4141240, -31}, 10), nd_at({588360, 4141240, 3}, 12)})));
  ASSERT_TRUE(validate(map).has_value());
  EXPECT_EQ(map.frame.origin_world_m, Eigen::Vector3d(588288.0, 4141184.0, -64.0));
  ASSERT_EQ(map.nds.size(), 2U);
  EXPECT_EQ(map.nds[0].key, (CellKey{2, 56, 33}));
  EXPECT_EQ(map.nds[0].mean_m, Eigen::Vector3d(2.25, 56.5, 33.75)) << "no digit is lost to UTM";
  EXPECT_EQ(map.nds[1].point_count, 12U);
  EXPECT_DOUBLE_EQ(map.nds[1].eigenvalues_m2[0], 0.03);
  EXPECT_EQ(map.cell_m, 1.0);
  EXPECT_EQ(map.point_count, 22U);
}

TEST_F(IngestNdMapTest, LeavesOutWhatIsNoNdAndSaysSo) {
  ForeignNd flat = nd_at({3, 0, 0}, 50);
  flat.covariance_m2.setZero();
  ForeignNds theirs = map_of({nd_at({1, 0, 0}, 9), nd_at({2, 0, 0}, 10), flat});
  theirs.single_point_count = 4;
  theirs.warnings = {"has seen better days"};
  const NdtMap map = value_of(ingest_nd_map(ctx_, {}, theirs));
  EXPECT_EQ(map.nds.size(), 1U);
  EXPECT_EQ(map.sparse_cell_count, 5U);
  EXPECT_EQ(map.degenerate_cell_count, 1U);
  EXPECT_THAT(ctx_.warnings, Contains(HasSubstr("map theirs: has seen better days")));
  EXPECT_THAT(ctx_.warnings,
              Contains(HasSubstr("contains NDs and no points: 1 of its 7 cells of 1 m")));
  EXPECT_EQ(ingest_nd_map(ctx_, {.min_points = 9}, theirs)->nds.size(), 2U);
}

// A mean just below an upper face, far from the origin of the frame.
TEST_F(IngestNdMapTest, KeepsAMeanInItsCellWhereRoundingWouldMoveIt) {
  for (const std::int32_t x : {100'000'000, -100'000'000}) {
    ForeignNd far = nd_at({x + 700'000, 0, 0}, 10);
    far.mean_in_cell_m.x() = std::nextafter(1.0, 0.0);
    const NdtMap map = value_of(ingest_nd_map(ctx_, {}, map_of({nd_at({x, 0, 0}, 10), far})));
    EXPECT_TRUE(validate(map).has_value());
  }
}

TEST_F(IngestNdMapTest, RefusesTilesThatCutCellsAndMapsWithoutNds) {
  const ForeignNds theirs = map_of({nd_at({1, 0, 0}, 9)});
  EXPECT_EQ(ingest_nd_map(ctx_, {.tile_m = 64.5}, theirs).error().code, ErrorCode::kBadValue);
  EXPECT_EQ(ingest_nd_map(ctx_, {}, theirs).error().code, ErrorCode::kEmptyMap);
  EXPECT_EQ(ingest_nd_map(ctx_, {}, map_of({})).error().code, ErrorCode::kEmptyMap);
  EXPECT_EQ(ingest_nd_map(ctx_, {}, map_of({nd_at({1 << 30, 0, 0}, 10)})).error().code,
            ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
