#include "formats/grid/cell_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

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

TEST(CellIndex, NumbersCellsAsTheyAreFirstMetHoweverManyThereAre) {
  Random random(2);
  CellIndex index;
  std::map<CellKey, std::uint32_t> expected;
  for (int i = 0; i < 60000; ++i) {
    const CellKey key{static_cast<std::int32_t>(random.below(60)) - 30,
                      static_cast<std::int32_t>(random.below(60)) - 30,
                      static_cast<std::int32_t>(random.below(20)) - 10};
    const auto next = static_cast<std::uint32_t>(expected.size());
    const std::uint32_t number = expected.try_emplace(key, next).first->second;
    ASSERT_EQ(index.add(key), number);
    ASSERT_EQ(index.keys()[number], key);
  }
  EXPECT_EQ(index.size(), expected.size());
  for (const auto& [key, number] : expected) EXPECT_EQ(index.find(key), number);
  EXPECT_EQ(index.find({31, 0, 0}), CellIndex::kNone);
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
    EXPECT_EQ(table.sums()[i].begins, expected.at(table.keys()[i]));
  }
}

}  // namespace
}  // namespace sightline
