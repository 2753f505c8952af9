#include "formats/grid/cell_index.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/base/random.h"

namespace sightline {
namespace {

std::vector<CellKey> keys_of(const std::vector<Eigen::Vector3d>& points_m, double cell_m) {
  std::vector<CellKey> keys(points_m.size());
  cell_keys(points_m, cell_m, keys);
  return keys;
}

TEST(CellKeys, FloorTheQuotientOfEachCoordinate) {
  const std::vector<Eigen::Vector3d> points_m = {{0.0, 1.9, 2.0}, {-0.1, -2.0, -2.1}};
  const std::vector<CellKey> expected = {{0, 0, 1}, {-1, -1, -2}};
  EXPECT_EQ(keys_of(points_m, 2.0), expected);
  EXPECT_TRUE(keys_of({}, 2.0).empty());
}

TEST(CellKeys, AreThoseOfOnePointAtATimeToTheBit) {
  Random random(1);
  for (const double cell_m : {0.1, 0.3, 0.7, 1.0, 2.0, 3.2}) {
    for (const double scale : {1.0, 1e3, 0x1p29}) {
      std::vector<Eigen::Vector3d> points_m;
      for (int i = 0; i < 500; ++i) {
        // Some at random, some on a face or the next number beside one.
        const double face_m = cell_m * std::floor(random.uniform(-scale, scale));
        const double away_m = random.below(2) == 0 ? -1e300 : 1e300;
        points_m.emplace_back(cell_m * random.uniform(-scale, scale), face_m,
                              std::nextafter(face_m, away_m));
      }
      const std::vector<CellKey> keys = keys_of(points_m, cell_m);
      for (std::size_t i = 0; i < points_m.size(); ++i) {
        ASSERT_EQ(keys[i], cell_key(points_m[i], cell_m)) << cell_m << " " << scale << " " << i;
      }
    }
  }
}

TEST(FindRuns, CutsKeysWhereTheyChange) {
  const CellKey a{1, 2, 3};
  const CellKey b{1, 2, 4};
  std::vector<CellRun> runs(6);
  ASSERT_EQ(find_runs(std::vector<CellKey>{a, a, b, a, a, a}, runs), 3U);
  EXPECT_EQ(runs[0].key, a);
  EXPECT_EQ(runs[0].count, 2U);
  EXPECT_EQ(runs[1].key, b);
  EXPECT_EQ(runs[1].begin, 2U);
  EXPECT_EQ(runs[1].count, 1U);
  EXPECT_EQ(runs[2].begin, 3U);
  EXPECT_EQ(runs[2].count, 3U);
  EXPECT_EQ(find_runs({}, runs), 0U);
}

TEST(FindRuns, TellsKeysApartThatDifferInOneNumberOnly) {
  const std::vector<CellKey> keys = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 1, -1}};
  std::vector<CellRun> runs(keys.size());
  EXPECT_EQ(find_runs(keys, runs), keys.size());
}

TEST(CellTable, GivesEachCellTheRunsOfItInTheirOrder) {
  struct Seen {
    std::vector<std::uint32_t> begins;
  };
  Random random(3);
  std::vector<CellRun> runs;
  std::map<CellKey, std::vector<std::uint32_t>> expected;
  CellTable<Seen> table;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    runs.push_back({{static_cast<std::int32_t>(random.below(90)), 0, 0}, i, 1});
    expected[runs.back().key].push_back(i);
  }
  const auto add = [](Seen& seen, const CellRun& run) { seen.begins.push_back(run.begin); };
  table.add(std::span<const CellRun>(runs).first(3000), add);
  table.add(std::span<const CellRun>(runs).subspan(3000), add);
  ASSERT_EQ(table.keys().size(), expected.size());
  for (std::size_t i = 0; i < table.keys().size(); ++i) {
    EXPECT_EQ(table.values()[i].begins, expected.at(table.keys()[i]));
  }
}

TEST(CellTable, NumbersCellsInTheOrderOfInsertion) {
  CellTable<double> map;
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.number_of({0, 0, 0}), CellTable<double>::kNone);
  EXPECT_EQ(map.find({0, 0, 0}), nullptr);

  EXPECT_TRUE(map.insert({5, -1, 2}, 0.5).is_new);
  EXPECT_EQ(map.insert({5, -1, 3}, 1.5).number, 1u);
  const CellTable<double>::Inserted again = map.insert({5, -1, 2}, 9.0);
  EXPECT_EQ(again.number, 0u);
  EXPECT_FALSE(again.is_new);

  EXPECT_EQ(map.size(), 2u);
  EXPECT_EQ(*map.find({5, -1, 2}), 0.5) << "the first value stays";
  *map.find({5, -1, 2}) = 7.0;
  EXPECT_EQ(map.values()[0], 7.0);
  EXPECT_EQ(map.keys()[1], (CellKey{5, -1, 3}));
  EXPECT_EQ(map.number_of({5, 2, -1}), CellTable<double>::kNone);
}

TEST(CellTable, HoldsCellsAtTheEndsOfTheGrid) {
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  CellTable<int> map;
  int count = 0;
  for (const std::int32_t x : {kLeast, -1, 0, kMost}) {
    for (const std::int32_t z : {kLeast, kMost}) map.insert({x, z, z}, count++);
  }
  EXPECT_EQ(map.size(), 8u);
  EXPECT_EQ(*map.find({kLeast, kMost, kMost}), 1);
  EXPECT_EQ(*map.find({kMost, kLeast, kLeast}), 6);
}

TEST(CellTable, ClearsAndKeepsTheMemory) {
  CellTable<int> map;
  for (int i = 0; i < 1000; ++i) map.insert({i, 0, 0}, i);
  const CellKey* const memory = map.keys().data();
  map.clear();
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.find({3, 0, 0}), nullptr);
  for (int i = 999; i >= 0; --i) map.insert({i, 0, 0}, -i);
  EXPECT_EQ(map.keys().data(), memory);
  EXPECT_EQ(map.keys()[0], (CellKey{999, 0, 0}));
  EXPECT_EQ(*map.find({3, 0, 0}), -3);
}

TEST(CellTable, MovesNoValueWithinWhatItReserved) {
  CellTable<int> map;
  map.reserve(500);
  map.insert({0, 0, 0}, 1);
  const int* const first = map.find({0, 0, 0});
  for (int i = 1; i < 500; ++i) map.insert({0, i, -i}, i);
  EXPECT_EQ(map.find({0, 0, 0}), first);
}

// Cells of a dense block, so that many are met again, of every size on the way through growth.
TEST(CellTable, IsTheStandardMapWhateverIsAskedOfIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    const auto random_key = [&] {
      const auto coordinate = [&] { return static_cast<std::int32_t>(random.below(40)) - 20; };
      return CellKey{coordinate(), coordinate(), coordinate()};
    };
    CellTable<std::uint64_t> map;
    std::map<CellKey, std::uint64_t> expected;
    std::vector<CellKey> order;
    for (std::uint64_t i = 0; i < 40000; ++i) {
      if (random.below(20000) == 0) {
        map.clear();
        expected.clear();
        order.clear();
      }
      const CellKey key = random_key();
      const bool is_new = expected.emplace(key, i).second;
      if (is_new) order.push_back(key);
      ASSERT_EQ(map.insert(key, i).is_new, is_new);
      const CellKey asked = random_key();
      const auto found = expected.find(asked);
      const std::uint64_t* const value = map.find(asked);
      ASSERT_EQ(value == nullptr, found == expected.end());
      if (value != nullptr) {
        ASSERT_EQ(*value, found->second);
      }
    }
    ASSERT_EQ(map.size(), expected.size());
    EXPECT_TRUE(std::ranges::equal(map.keys(), order));
    for (std::size_t i = 0; i < order.size(); ++i) {
      ASSERT_EQ(map.values()[i], expected.at(order[i]));
      ASSERT_EQ(map.number_of(order[i]), i);
    }
  }
}

CellKey random_cell(Random& random, int reach) {
  const auto any = [&] { return static_cast<std::int32_t>(random.uniform(-reach, reach)); };
  return {any(), any(), any()};
}

TEST(CellSet, HoldsNothingWhereItWasGivenNothing) {
  const CellSet none({});
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.contains({0, 0, 0}));
}

TEST(CellSet, HoldsWhatItWasGivenAndNothingElse) {
  Random random(11);
  for (const int reach : {3, 20, 1000000}) {
    for (const std::size_t count : {std::size_t{1}, std::size_t{60}, std::size_t{20000}}) {
      std::vector<CellKey> cells;
      for (std::size_t i = 0; i < count; ++i) cells.push_back(random_cell(random, reach));
      const std::set<CellKey> expected(cells.begin(), cells.end());
      const CellSet set(cells);
      EXPECT_FALSE(set.empty());
      for (const CellKey& cell : cells) EXPECT_TRUE(set.contains(cell));
      for (int i = 0; i < 20000; ++i) {
        const CellKey cell = random_cell(random, reach);
        ASSERT_EQ(set.contains(cell), expected.contains(cell))
            << cell.x << " " << cell.y << " " << cell.z << " of " << count;
      }
    }
  }
}

}  // namespace
}  // namespace sightline
