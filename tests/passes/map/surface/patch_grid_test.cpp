#include "passes/map/surface/patch_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "formats/base/random.h"
#include "passes/map/surface/patch_evidence.h"

namespace sightline {
namespace {

constexpr double kCell_m = 0.5;

std::vector<SurfacePatch> random_patches(int count) {
  Random random(7);
  std::vector<SurfacePatch> patches(static_cast<std::size_t>(count));
  for (SurfacePatch& patch : patches) {
    patch.centre_m = {random.uniform(-9.0, 9.0), random.uniform(-3.0, 20.0),
                      random.uniform(-40.0, 8.0)};
    patch.normal = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(0.0, 1.0)};
    patch.normal.normalize();
    patch.half_side_m = random.uniform(0.2, 1.5);
  }
  return patches;
}

TEST(PatchGrid, FindsAPatchWhereItLiesAndNumbersEachCellOnce) {
  const std::vector<SurfacePatch> patches = random_patches(300);
  const PatchGrid grid(patches, kCell_m);
  std::set<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < patches.size(); ++i) {
    for (int square = 0; square < kSquaresOfPatch; square += 9) {
      const CellKey cell = cell_key(grid.plane(i).middle_m(square), kCell_m);
      if (square % 27 != 0 && grid.number_of(cell) == PatchGrid::kNone) continue;  // a corner
      numbers.insert(grid.number_of(cell));
    }
    const CellKey cell = cell_key(patches[i].centre_m, kCell_m);
    ASSERT_NE(grid.number_of(cell), PatchGrid::kNone);
    EXPECT_EQ(std::ranges::count(grid.patches_at(cell), i), 1);
    EXPECT_TRUE(std::ranges::is_sorted(grid.patches_at(cell)));
  }
  numbers.erase(PatchGrid::kNone);
  EXPECT_LT(*numbers.rbegin(), grid.cell_count());
  for (const CellKey& beyond : {CellKey{1000, 0, 0}, CellKey{0, -1000, 0}, CellKey{0, 0, 1000},
                                CellKey{0, 0, -1000}, CellKey{-1000, 0, 0}}) {
    EXPECT_EQ(grid.number_of(beyond), PatchGrid::kNone);
    EXPECT_TRUE(grid.patches_at(beyond).empty());
  }
}

TEST(PatchGrid, TellsHeightsThatHoldThePlanesOfACell) {
  const std::vector<SurfacePatch> patches = random_patches(300);
  const PatchGrid grid(patches, kCell_m);
  Random random(8);
  int narrow = 0;
  for (std::uint32_t i = 0; i < patches.size(); ++i) {
    const PatchPlane& plane = grid.plane(i);
    for (int j = 0; j < 50; ++j) {
      const Eigen::Vector3d at_m =
          plane.centre_m + plane.half_side_m * (random.uniform(-1.0, 1.0) * plane.side +
                                                random.uniform(-1.0, 1.0) * plane.other_side);
      const CellKey cell = cell_key(at_m, kCell_m);
      if (std::ranges::count(grid.patches_at(cell), i) == 0) continue;
      const PatchGrid::Heights heights = grid.heights_of(grid.number_of(cell));
      const double height = (at_m.z() / kCell_m - cell.z) * PatchGrid::kHeightsOfCell;
      EXPECT_GE(height, heights.low);
      EXPECT_LE(height, heights.high);
      narrow += heights.high - heights.low < PatchGrid::kHeightsOfCell ? 1 : 0;
    }
  }
  EXPECT_GT(narrow, 100);
}

TEST(PatchGrid, HoldsNothingWithoutPatches) {
  const PatchGrid grid({}, kCell_m);
  EXPECT_EQ(grid.cell_count(), 0U);
  EXPECT_TRUE(grid.patches_at({0, 0, 0}).empty());
  const PatchGrid::Stretch stretch = grid.stretch_of({1.0, 2.0, 3.0}, Eigen::Vector3d::UnitX());
  EXPECT_GT(stretch.enter_m, stretch.leave_m);
}

TEST(SortedByCell, GivesTheThingsOfACellInTheirOrder) {
  constexpr std::uint32_t kNone = SortedByCell::kNone;
  SortedByCell sorted;
  sorted.sort(std::vector<std::uint32_t>{9, 9}, 10);  // what was before does not matter
  sorted.sort(std::vector<std::uint32_t>{2, 0, kNone, 2, 0}, 4);
  const std::vector<std::vector<std::uint32_t>> expected{{1, 4}, {}, {0, 3}, {}};
  for (std::uint32_t cell = 0; cell < 4; ++cell) {
    EXPECT_TRUE(std::ranges::equal(sorted.things_of(cell), expected[cell])) << cell;
  }
  EXPECT_EQ(sorted.later(sorted.things_of(0)[0]), 3U) << "the last there is";
}

TEST(SortedByCell, NamesWhatComesLater) {
  std::vector<std::uint32_t> cells(40);
  for (std::uint32_t i = 0; i < 40; ++i) cells[i] = 39 - i;
  SortedByCell sorted;
  sorted.sort(cells, 40);
  EXPECT_EQ(sorted.later(sorted.things_of(3)[0]), 39U - 15U);
}

}  // namespace
}  // namespace sightline
