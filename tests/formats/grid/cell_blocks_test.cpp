#include "formats/grid/cell_blocks.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "formats/base/random.h"

namespace sightline {
namespace {

// Each once, in random order, on both sides of zero.
std::vector<CellKey> some_cells(Random& random, int reach, std::size_t count) {
  std::set<CellKey> met;
  std::vector<CellKey> cells;
  const auto any = [&] { return static_cast<std::int32_t>(random.uniform(-reach, reach)); };
  for (std::size_t i = 0; i < count; ++i) {
    const CellKey cell{any(), any(), any()};
    if (met.insert(cell).second) cells.push_back(cell);
  }
  return cells;
}

std::map<CellKey, std::uint32_t> numbers_of(const std::vector<CellKey>& cells) {
  std::map<CellKey, std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < cells.size(); ++i) numbers[cells[i]] = i;
  return numbers;
}

TEST(CellBlocks, AreNoneOfNoCells) {
  const CellBlocks none({});
  EXPECT_EQ(none.size(), 0U);
  EXPECT_TRUE(none.cells_at({0, 0, 0}).empty());
}

TEST(CellBlocks, HoldEachCellOnceInItsBlockByNumber) {
  Random random(1);
  for (const int reach : {4, 20, 100000}) {
    const std::vector<CellKey> cells = some_cells(random, reach, 3000);
    const CellBlocks blocks(cells);
    std::vector<int> met(cells.size(), 0);
    for (std::size_t block = 0; block < blocks.size(); ++block) {
      const CellBlocks::Cell* last = nullptr;
      for (const CellBlocks::Cell& cell : blocks.cells(block)) {
        ASSERT_LT(cell.number, cells.size());
        EXPECT_EQ(cell.key, cells[cell.number]);
        EXPECT_EQ(CellBlocks::block(cell.key), blocks.key(block));
        EXPECT_TRUE(last == nullptr || last->number < cell.number);
        last = &cell;
        ++met[cell.number];
      }
      EXPECT_EQ(blocks.cells_at(blocks.key(block)).data(), blocks.cells(block).data());
    }
    EXPECT_EQ(met, std::vector<int>(cells.size(), 1));
  }
}

// Against a look into a table for each neighbour, with windows that reach through several blocks to
// some sides and nowhere to others.
TEST(CellWindow, KnowsEveryCellAroundEachOfABlock) {
  Random random(2);
  const std::vector<std::tuple<CellKey, CellKey>> reaches = {{{0, 0, 0}, {0, 0, 0}},
                                                             {{1, 1, 1}, {1, 1, 1}},
                                                             {{2, 2, 1}, {2, 2, 8}},
                                                             {{0, 9, 0}, {17, 0, 3}}};
  for (const int reach : {5, 12, 1000}) {
    const std::vector<CellKey> cells = some_cells(random, reach, 400);
    const std::map<CellKey, std::uint32_t> numbers = numbers_of(cells);
    const CellBlocks blocks(cells);
    for (const auto& [below, above] : reaches) {
      CellWindow window(blocks, below, above);
      for (std::size_t block = 0; block < blocks.size(); ++block) {
        window.move_to(block);
        const CellKey& key = blocks.key(block);
        for (std::int32_t x = 8 * key.x - below.x; x < 8 * key.x + 8 + above.x; ++x) {
          for (std::int32_t y = 8 * key.y - below.y; y < 8 * key.y + 8 + above.y; ++y) {
            for (std::int32_t z = 8 * key.z - below.z; z < 8 * key.z + 8 + above.z; ++z) {
              const auto entry = numbers.find({x, y, z});
              const bool is_there = entry != numbers.end();
              ASSERT_EQ(window.number_of({x, y, z}), is_there ? entry->second : CellWindow::kNone)
                  << x << " " << y << " " << z;
              ASSERT_EQ(window.holds({x, y, z}), is_there);
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace sightline
