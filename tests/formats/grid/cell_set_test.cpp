#include "formats/grid/cell_set.h"

#include <gtest/gtest.h>

#include <set>

#include "formats/base/random.h"

namespace sightline {
namespace {

CellKey random_cell(Random& random, int reach) {
  const auto any = [&] { return static_cast<std::int32_t>(random.uniform(-reach, reach)); };
  return {any(), any(), any()};
}

TEST(CellSet, HoldsNothingWhereItWasGivenNothing) {
  const CellSet none({});
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.contains({0, 0, 0}));
}

// Against the standard library's set, of few cells and of many, near each other and far.
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
