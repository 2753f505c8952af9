#include "passes/map/surface/surface_tile.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <thread>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr double kCell_m = 0.5;
constexpr double kTile_m = 8.0;

std::vector<SurfacePatch> random_patches(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<SurfacePatch> patches(static_cast<std::size_t>(count));
  for (SurfacePatch& patch : patches) {
    patch.centre_m = {random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0), 0.0};
    patch.key = cell_key(patch.centre_m, kCell_m);
    patch.half_side_m = random.uniform(0.1, 0.4);
  }
  return patches;
}

TEST(PatchesByTile, GivesEachTileWhateverCameWhen) {
  PatchesByTile by_tile(kCell_m, kTile_m);
  std::vector<SurfacePatch> all;
  std::vector<std::thread> threads;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const std::vector<SurfacePatch> patches = random_patches(seed, 1000);
    all.insert(all.end(), patches.begin(), patches.end());
    threads.emplace_back([&by_tile, patches] { by_tile.add(patches); });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_TRUE(by_tile.finish());
  const Surface order{{}, kCell_m, kTile_m, {}};
  const auto place = [&](const SurfacePatch& patch) { return order_of(patch, order); };
  std::ranges::sort(all, {}, place);
  std::vector<SurfacePatch> found;
  for (const TileKey& tile : by_tile.tiles()) {
    const std::vector<SurfacePatch> of_tile = *by_tile.of_tile(tile);
    EXPECT_FALSE(of_tile.empty());
    found.insert(found.end(), of_tile.begin(), of_tile.end());
  }
  ASSERT_EQ(found.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(place(found[i]), place(all[i]));
  EXPECT_TRUE(by_tile.of_tile({100, 100})->empty());
}

TEST(PatchesByTile, FindsWhatLiesOverABox) {
  PatchesByTile by_tile(kCell_m, kTile_m);
  const std::vector<SurfacePatch> patches = random_patches(7, 2000);
  by_tile.add(patches);
  ASSERT_TRUE(by_tile.finish());
  const Eigen::AlignedBox2d box_m(Eigen::Vector2d(-9.5, -30.0), Eigen::Vector2d(8.0, 3.0));
  const auto is_over = [&](const SurfacePatch& patch) {
    return box_m.contains(patch.centre_m.head<2>());
  };
  const std::vector<SurfacePatch> found = *by_tile.over(box_m);
  EXPECT_TRUE(std::ranges::all_of(found, is_over));
  EXPECT_EQ(std::ssize(found), std::ranges::count_if(patches, is_over));
}

}  // namespace
}  // namespace sightline
