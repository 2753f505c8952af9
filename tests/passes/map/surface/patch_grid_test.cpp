#include "passes/map/surface/patch_grid.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

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

std::vector<SurfacePatch> unlike_patches(Random& random) {
  std::vector<SurfacePatch> patches(800);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    SurfacePatch& patch = patches[i];
    patch.centre_m = {random.uniform(-15.0, 15.0), random.uniform(-15.0, 15.0),
                      random.uniform(-2.0, 4.0)};
    patch.normal = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(0.0, 1.0)};
    if (i % 4 == 0) patch.normal = {0.0, 0.0, 1.0};
    if (i % 4 == 1) patch.normal.z() = 0.0;
    if (i % 4 == 2) patch.normal = {0.01, 0.02, 1.0};
    patch.normal.normalize();
    patch.half_side_m = i % 5 == 0 ? 1.8 : 0.36;
    patch.key = cell_key(patch.centre_m, kCell_m);
  }
  return patches;
}

using Passes = std::set<std::pair<std::uint32_t, int>>;  // patches and squares

Passes followed(const PatchGrid& grid, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  FollowedRays rays;
  follow_ray(from_m, to_m, grid, rays);
  Passes passes;
  for (const RayVisit& visit : rays.visits) {
    const FollowedRay& ray = rays.rays[visit.ray];
    for (const std::uint32_t patch : grid.patches_of(visit.cell)) {
      const int square = square_passed(ray, patch, visit.cell, grid);
      if (square < 0) continue;
      EXPECT_TRUE(grid.lanes().patch(patch).may_cross(ray.lanes, visit.enter_m, visit.leave_m));
      EXPECT_TRUE(passes.insert({patch, square}).second) << "twice";
    }
  }
  return passes;
}

Passes asked(const PatchGrid& grid, std::size_t patch_count, const Eigen::Vector3d& from_m,
             const Eigen::Vector3d& to_m) {
  const double range_m = (to_m - from_m).norm();
  const Eigen::Vector3d direction = (to_m - from_m) / range_m;
  Passes passes;
  for (std::uint32_t i = 0; i < patch_count; ++i) {
    const PatchPlane& plane = grid.plane(i);
    const double slope = plane.normal.dot(direction);
    const double distance_m = plane.normal.dot(plane.centre_m - from_m) / slope;
    const double beyond_m = range_m - distance_m;
    if (std::abs(slope) < 0.17 || !(distance_m > 0.0)) continue;
    if (!(beyond_m > 0.4) || beyond_m * std::abs(slope) < 0.2) continue;
    const Eigen::Vector3d at_m = from_m + distance_m * direction;
    const std::span<const std::uint32_t> there = grid.patches_at(cell_key(at_m, kCell_m));
    const int square = plane.square_of(at_m);
    if (square >= 0 && std::ranges::count(there, i) > 0) passes.insert({i, square});
  }
  return passes;
}

TEST(FollowedRays, PassWhatEachPatchAlonePasses) {
  Random random(1);
  const std::vector<SurfacePatch> patches = unlike_patches(random);
  const PatchGrid grid(patches, kCell_m);
  std::size_t count = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3d from_m(random.uniform(-25.0, 25.0), random.uniform(-25.0, 25.0),
                                 random.uniform(-3.0, 6.0));
    Eigen::Vector3d to_m(random.uniform(-18.0, 18.0), random.uniform(-18.0, 18.0),
                         random.uniform(-3.0, 6.0));
    // Along axes, and nearly so.
    if (i % 6 == 1) to_m.x() = from_m.x();
    if (i % 6 == 2) to_m.y() = from_m.y() + 1e-5;
    if (i % 6 == 3) to_m.z() = from_m.z() + 1e-15;
    if (i % 60 == 4) to_m.head<2>() = from_m.head<2>();
    const Passes passes = followed(grid, from_m, to_m);
    EXPECT_EQ(passes, asked(grid, patches.size(), from_m, to_m)) << "ray " << i;
    count += passes.size();
  }
  EXPECT_GT(count, 3000U);
}

TEST(FollowedRays, EndAtTheLongestPass) {
  SurfacePatch wall;
  wall.centre_m = {0.2, 0.2, 0.2};
  wall.normal = Eigen::Vector3d::UnitX();
  wall.half_side_m = 0.36;
  const PatchGrid grid(std::vector<SurfacePatch>{wall}, kCell_m);
  EXPECT_EQ(followed(grid, {-59.0, 0.2, 0.2}, {10.0, 0.2, 0.2}).size(), 1U);
  EXPECT_TRUE(followed(grid, {-61.0, 0.2, 0.2}, {10.0, 0.2, 0.2}).empty());
}

TEST(FollowedRays, VisitOnlyFewCellsAboveTheGround) {
  std::vector<SurfacePatch> ground(400);
  for (std::size_t i = 0; i < ground.size(); ++i) {
    const std::size_t column = i % 20;
    const std::size_t row = i / 20;
    ground[i].centre_m = {0.5 * static_cast<double>(column) + 0.25,
                          0.5 * static_cast<double>(row) + 0.25, 0.1};
    ground[i].half_side_m = 0.36;
  }
  const PatchGrid grid(ground, kCell_m);
  FollowedRays rays;
  follow_ray({0.1, 5.1, 0.4}, {9.9, 5.1, 0.2}, grid, rays);  // in one layer of cells
  EXPECT_TRUE(rays.visits.empty());
  EXPECT_TRUE(rays.rays.empty());
  follow_ray({0.1, 5.1, 0.4}, {9.9, 5.1, -0.2}, grid, rays);
  EXPECT_GE(rays.visits.size(), 1U);
  EXPECT_LE(rays.visits.size(), 3U);
}

}  // namespace
}  // namespace sightline
