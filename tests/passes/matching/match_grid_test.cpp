#include "passes/matching/grid/match_grid.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "formats/base/random.h"
#include "passes/matching/grid/cell_columns.h"
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

constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();

std::int32_t between(Random& random, std::int32_t low, std::int32_t high) {
  return low + static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(high - low) + 1));
}

CellKey random_cell(Random& random, const CellKey& low, const CellKey& high) {
  return {between(random, low.x, high.x), between(random, low.y, high.y),
          between(random, low.z, high.z)};
}

std::int32_t record_of(const CellColumns& columns, const CellKey& key) {
  return find_record(columns.records(), key.x, key.y, key.z);
}

TEST(CellColumns, FindWhatAMapOfTheSameCellsFinds) {
  Random random(4);
  for (int trial = 0; trial < 50; ++trial) {
    const std::int32_t far = between(random, -1000000, 1000000);
    const std::int32_t up = between(random, -30000, 30000);
    const CellKey low{far - between(random, 0, 12), -far, up};
    const CellKey high{far, -far + between(random, 0, 12), up + between(random, 0, 9)};
    std::map<CellKey, std::int32_t> numbers;
    std::vector<CellKey> keys;
    for (int i = between(random, 1, 200); i > 0; --i) {
      const CellKey key = random_cell(random, low, high);
      if (numbers.emplace(key, static_cast<std::int32_t>(keys.size())).second) keys.push_back(key);
    }
    const CellColumns columns(keys);
    if (columns.is_empty()) continue;  // too few cells in too many columns
    for (int asked = 0; asked < 2000; ++asked) {
      const CellKey key = random_cell(random, {low.x - 2, low.y - 2, low.z - 2},
                                      {high.x + 2, high.y + 2, high.z + 2});
      const auto known = numbers.find(key);
      ASSERT_EQ(record_of(columns, key), known == numbers.end() ? 0 : known->second + 1);
    }
    for (const std::int32_t end : {kLeast, kMost}) {
      EXPECT_EQ(record_of(columns, {end, low.y, low.z}), 0);
      EXPECT_EQ(record_of(columns, {low.x, end, low.z}), 0);
      EXPECT_EQ(record_of(columns, {low.x, low.y, end}), 0);
    }
  }
}

TEST(CellColumns, AreNoneWhereTheyWouldTakeMoreMemoryThanTheirCellsAreWorth) {
  const auto are_none = [](std::vector<CellKey> keys) { return CellColumns(keys).is_empty(); };
  EXPECT_TRUE(are_none({}));
  EXPECT_FALSE(are_none({{5, 5, 5}}));
  EXPECT_FALSE(are_none({{0, 0, 0}, {3, 3, 0}}));  // 16 columns, 8 for each
  EXPECT_TRUE(are_none({{0, 0, 0}, {3, 4, 0}}));
  EXPECT_TRUE(are_none({{kLeast, 0, 0}, {kMost, 0, 0}}));
  EXPECT_TRUE(are_none({{kLeast, kLeast, 0}, {kMost, kMost, 0}}));
  EXPECT_FALSE(are_none({{0, 0, -32768}, {0, 0, 32766}}));
  EXPECT_TRUE(are_none({{0, 0, -32768}, {0, 0, 32767}}));  // 65536 cells high
  EXPECT_TRUE(are_none({{0, 0, 32768}}));
}

TEST(CellColumns, OfAMatchGridTellItsRecords) {
  const MatchGrid grid = make_match_grid(simple_map(room_points(7, 6000, 0.02), 1.0));
  ASSERT_FALSE(grid.columns.is_empty());
  RollingMatchGrid rolling(1.0);  // has none
  rolling.put(simple_map(room_points(8, 6000, 0.02), 1.0).nds,
              [](const Nd&) -> Eigen::Matrix3d { return Eigen::Matrix3d::Identity(); });
  rolling.finish();
  Random random(5);
  for (int trial = 0; trial < 5000; ++trial) {
    const CellKey key = cell_key(random_vector(random, -14.0, 14.0), 1.0);
    EXPECT_EQ(record_of_cell(grid, key), find_cell(grid, key) + 1);
    EXPECT_EQ(record_of_cell(rolling.grid(), key), find_cell(rolling.grid(), key) + 1);
    prefetch_cell(grid, key);
    prefetch_cell(rolling.grid(), key);
  }
}

}  // namespace
}  // namespace sightline
