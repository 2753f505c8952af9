#include "formats/grid/flat_cell_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <unordered_map>

#include "formats/base/random.h"

namespace sightline {
namespace {

TEST(FlatCellMap, NumbersCellsInTheOrderOfInsertion) {
  FlatCellMap<double> map;
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.number_of({0, 0, 0}), FlatCellMap<double>::kNone);
  EXPECT_EQ(map.find({0, 0, 0}), nullptr);

  EXPECT_TRUE(map.insert({5, -1, 2}, 0.5).is_new);
  EXPECT_EQ(map.insert({5, -1, 3}, 1.5).number, 1u);
  const FlatCellMap<double>::Inserted again = map.insert({5, -1, 2}, 9.0);
  EXPECT_EQ(again.number, 0u);
  EXPECT_FALSE(again.is_new);

  EXPECT_EQ(map.size(), 2u);
  EXPECT_EQ(*map.find({5, -1, 2}), 0.5) << "the first value stays";
  *map.find({5, -1, 2}) = 7.0;
  EXPECT_EQ(map.values()[0], 7.0);
  EXPECT_EQ(map.keys()[1], (CellKey{5, -1, 3}));
  EXPECT_EQ(map.number_of({5, 2, -1}), FlatCellMap<double>::kNone);
}

TEST(FlatCellMap, HoldsCellsAtTheEndsOfTheGrid) {
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  FlatCellMap<int> map;
  int count = 0;
  for (const std::int32_t x : {kLeast, -1, 0, kMost}) {
    for (const std::int32_t z : {kLeast, kMost}) map.insert({x, z, z}, count++);
  }
  EXPECT_EQ(map.size(), 8u);
  EXPECT_EQ(*map.find({kLeast, kMost, kMost}), 1);
  EXPECT_EQ(*map.find({kMost, kLeast, kLeast}), 6);
}

TEST(FlatCellMap, ClearsAndKeepsTheMemory) {
  FlatCellMap<int> map;
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

TEST(FlatCellMap, MovesNoValueWithinWhatItReserved) {
  FlatCellMap<int> map;
  map.reserve(500);
  map.insert({0, 0, 0}, 1);
  const int* const first = map.find({0, 0, 0});
  for (int i = 1; i < 500; ++i) map.insert({0, i, -i}, i);
  EXPECT_EQ(map.find({0, 0, 0}), first);
}

struct StandardHash {
  std::size_t operator()(const CellKey& key) const { return hash_of(key); }
};

// Cells of a dense block, so that many are met again, of every size on the way through growth.
TEST(FlatCellMap, IsTheStandardMapWhateverIsAskedOfIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    const auto random_key = [&] {
      const auto coordinate = [&] { return static_cast<std::int32_t>(random.below(40)) - 20; };
      return CellKey{coordinate(), coordinate(), coordinate()};
    };
    FlatCellMap<std::uint64_t> map;
    std::unordered_map<CellKey, std::uint64_t, StandardHash> expected;
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

}  // namespace
}  // namespace sightline
