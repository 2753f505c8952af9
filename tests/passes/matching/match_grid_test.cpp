#include "passes/matching/grid/match_grid.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>

#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

TEST(MatchGrid, KnowsTheGaussConstantsOfTwoMetreCells) {
  const GaussConstants gauss = gauss_constants(2.0);
  EXPECT_NEAR(gauss.d1, -4.196518186951, 1e-12);
  EXPECT_NEAR(gauss.d2, 0.248478510124, 1e-12);
}

TEST(MatchGrid, ListsAnNdInItsOwnCellAndInItsSixNeighbours) {
  NdtMap map;
  Nd nd;
  nd.key = {3, -1, 0};
  nd.point_count = 10;
  nd.mean_m = {7.0, -1.0, 1.0};
  nd.covariance_m2 = Eigen::Vector3d(0.5, 0.25, 0.125).asDiagonal();
  decompose(nd);
  map.nds = {nd};
  const MatchGrid grid = make_match_grid(map);
  ASSERT_EQ(grid.cells.size(), 7u);
  const std::vector<CellKey> from = {{3, -1, 0}, {4, -1, 0}, {2, -1, 0}, {3, 0, 0},
                                     {3, -2, 0}, {3, -1, 1}, {3, -1, -1}};
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::int32_t cell = find_cell(grid, from[i]);
    ASSERT_NE(cell, MatchGrid::kNone);
    EXPECT_EQ(grid.neighbourhoods[static_cast<std::size_t>(cell)][i], 0);
  }
  EXPECT_EQ(find_cell(grid, {4, 0, 0}), MatchGrid::kNone);
  const Eigen::Matrix3d expected = Eigen::Vector3d(2.0, 4.0, 8.0).asDiagonal();
  EXPECT_TRUE(grid.nds[0].information_per_m2.isApprox(expected, 1e-12));
}

TEST(MatchGrid, FindsWhatASearchThroughAllNdsFinds) {
  const NdtMap map = simple_map(room_points(7, 6000, 0.02), 1.0);
  const MatchGrid grid = make_match_grid(map);
  ASSERT_GT(map.nds.size(), 100u);
  Random random(3);
  for (int trial = 0; trial < 5000; ++trial) {
    const CellKey key = cell_key(random_vector(random, -14.0, 14.0), 1.0);
    std::set<std::int32_t> expected;
    for (std::size_t i = 0; i < map.nds.size(); ++i) {
      const CellKey& other = map.nds[i].key;
      const int steps =
          std::abs(other.x - key.x) + std::abs(other.y - key.y) + std::abs(other.z - key.z);
      if (steps <= 1) expected.insert(static_cast<std::int32_t>(i));
    }
    const std::int32_t cell = find_cell(grid, key);
    std::set<std::int32_t> found;
    if (cell != MatchGrid::kNone) {
      for (const std::int32_t nd : grid.neighbourhoods[static_cast<std::size_t>(cell)]) {
        if (nd != MatchGrid::kNone) found.insert(nd);
      }
    }
    EXPECT_EQ(found, expected);
  }
}

TEST(MatchGrid, OfAnEmptyMapFindsNothing) {
  EXPECT_EQ(find_cell(make_match_grid(NdtMap{}), {0, 0, 0}), MatchGrid::kNone);
  EXPECT_EQ(find_cell(MatchGrid{}, {0, 0, 0}), MatchGrid::kNone);
}

}  // namespace
}  // namespace sightline
