#include "formats/surroundings/surface.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/base/random.h"
#include "formats/tables/stored_table_writer.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

Surface two_patches() {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  surface.patches.push_back({{0, 0, 0}, {0.25, 0.2, 0.1}, {0.0, 0.6, 0.8}, 0.3});
  surface.patches.push_back(
      {{0, 1, 0}, {0.25, 0.7, 0.1}, {1.0, 0.0, 0.0}, 0.2, 0x8000000000000001});
  return surface;
}

TEST(Surface, LaysSidesLevelOnWallsAndAlongTheAxesOnGround) {
  SurfacePatch wall;
  wall.normal = Eigen::Vector3d(3.0, -4.0, 1.0).normalized();
  EXPECT_NEAR(side_of(wall).z(), 0.0, 1e-15);
  EXPECT_NEAR(side_of(wall).dot(wall.normal), 0.0, 1e-15);
  EXPECT_NEAR(side_of(wall).norm(), 1.0, 1e-15);
  SurfacePatch ground;
  EXPECT_NEAR(std::abs(side_of(ground).y()), 1.0, 1e-15);
}

TEST(Surface, VisitsTheMiddlesOfSolidSquaresAlone) {
  SurfacePatch patch{{0, 0, 0}, {1.0, 2.0, 3.0}, {0.0, 0.6, 0.8}, 0.4, 0x80f000000000a501};
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  for (const int parts : {1, 3}) {
    int count = 0;
    Eigen::Vector3d first_m = Eigen::Vector3d::Zero();
    visit_solid_squares(patch, parts, [&](const Eigen::Vector3d& middle_m) {
      const Eigen::Vector3d off_m = middle_m - patch.centre_m;
      EXPECT_NEAR(off_m.dot(patch.normal), 0.0, 1e-12);
      const int square = square_at(off_m.dot(along) / 0.4, off_m.dot(across) / 0.4);
      EXPECT_TRUE((patch.solid >> square & 1U) != 0) << square;
      if (count++ == 0) first_m = off_m;
    });
    EXPECT_EQ(count, 10 * parts * parts);
    EXPECT_NEAR(first_m.dot(along), -0.4 + 0.05 / parts, 1e-12);
  }
}

TEST(Surface, RefusesWrongPatchesAndPatchesOutOfOrder) {
  Surface surface = two_patches();
  surface.patches[1].normal *= 1.01;
  EXPECT_EQ(failure_of(validate(surface)).place, "patch 1");
  for (const auto& spoil : std::vector<std::function<void(Surface&)>>{
           [](Surface& narrow) { narrow.patches[0].half_side_m = 0.0; },
           [](Surface& empty) { empty.patches[1].solid = 0; },
           [](Surface& unordered) { std::swap(unordered.patches[0], unordered.patches[1]); }}) {
    surface = two_patches();
    spoil(surface);
    EXPECT_FALSE(validate(surface).has_value());
  }
}

TEST(Surface, CountsSquaresAlongTheSideThenAcross) {
  EXPECT_EQ(square_at(-1.0, -1.0), 0);
  EXPECT_EQ(square_at(1.0, -1.0), 7);
  EXPECT_EQ(square_at(-1.0, 1.0), 56);
  EXPECT_EQ(square_at(0.01, 0.26), 8 * 5 + 4);
}

Surface random_surface(int count) {
  Random random(static_cast<std::uint64_t>(count) + 1);
  Surface surface;
  surface.frame.origin_world_m = {1.0, 2.0, 3.0};
  surface.cell_m = 0.5;
  surface.tile_m = 8.0;
  for (int i = 0; i < count; ++i) {
    SurfacePatch patch;
    patch.centre_m = {random.uniform(-40.0, 40.0), random.uniform(-20.0, 20.0),
                      random.uniform(0.0, 3.0)};
    patch.key = cell_key(patch.centre_m, surface.cell_m);
    patch.half_side_m = random.uniform(0.1, 0.4);
    surface.patches.push_back(patch);
  }
  std::ranges::sort(surface.patches, {},
                    [&](const SurfacePatch& patch) { return order_of(patch, surface); });
  return surface;
}

Result<TiledSurface> opened(std::vector<std::byte> bytes) {
  return from_stored<TiledSurface>(StoredBytes(std::move(bytes)));
}

TEST(TiledSurface, HoldsThePatchesInTheirOrder) {
  for (const int count : {0, 1, 5000}) {
    const Surface surface = random_surface(count);
    const TiledSurface tiled = surface;
    EXPECT_TRUE(validate(tiled));
    EXPECT_EQ(tiled.row_count(), surface.patches.size());
    EXPECT_TRUE(to_bytes(*tiled.whole()) == to_bytes(surface));
    double widest_m = 0.0;
    for (const SurfacePatch& p : surface.patches) widest_m = std::max(widest_m, p.half_side_m);
    EXPECT_EQ(tiled.reach_m(), widest_m);
  }
}

TEST(TiledSurface, FindsAllThatLiesOverABoxAndLittleElse) {
  const Surface surface = random_surface(5000);
  const TiledSurface tiled = surface;
  const Eigen::AlignedBox2d box_m(Eigen::Vector2d(-9.0, -3.0), Eigen::Vector2d(17.0, 0.5));
  const Surface found = *tiled.over(box_m);
  EXPECT_TRUE(validate(found));
  const auto over = [](const Eigen::AlignedBox2d& of_m) {
    return [=](const SurfacePatch& patch) { return of_m.contains(patch.centre_m.head<2>()); };
  };
  EXPECT_EQ(std::ranges::count_if(found.patches, over(box_m)),
            std::ranges::count_if(surface.patches, over(box_m)));
  const Eigen::Vector2d tile_m(surface.tile_m, surface.tile_m);
  const Eigen::AlignedBox2d near_m(box_m.min() - tile_m, box_m.max() + tile_m);
  EXPECT_TRUE(std::ranges::all_of(found.patches, over(near_m)));
  EXPECT_LT(found.patches.size(), surface.patches.size() / 2);
}

TEST(TiledSurface, SurvivesDiskAndIsReadByAnotherProgramsEnvelope) {
  const Surface surface = random_surface(300);
  const std::vector<std::byte> bytes = sealed(TiledSurface(surface));
  EXPECT_TRUE(unseal(bytes, "surface", ArtifactTraits<TiledSurface>::kVersion));
  const TiledSurface back = value_of(opened(bytes));
  EXPECT_TRUE(sealed(back) == bytes);
  EXPECT_TRUE(to_bytes(*back.whole()) == to_bytes(surface));
}

TEST(TiledSurface, IsRefusedCutShortOrDamagedAtEveryByte) {
  const std::vector<std::byte> bytes = sealed(TiledSurface(random_surface(3)));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(opened({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}));
    std::vector<std::byte> damaged = bytes;
    damaged[size] ^= std::byte{0x10};
    EXPECT_FALSE(opened(std::move(damaged))) << size;
  }
}

TEST(TiledSurface, AnyPayloadIsRefusedOrValid) {
  const TiledSurface surface = random_surface(4);
  std::vector<std::byte> payload;
  ASSERT_TRUE(visit_payload(surface, [&](std::span<const std::byte> piece) -> Result<void> {
    payload.insert(payload.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_EQ(payload.size(), payload_size(surface));
  int refused = 0;
  for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
    std::vector<std::byte> changed = payload;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    TiledSurface found;
    if (open_payload(StoredBytes(std::move(changed)), found)) {
      EXPECT_TRUE(validate(found)) << bit;
    } else {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);  // rows have no index beside them that could contradict
}

TEST(TiledSurface, RefusesTilesThatDoNotAscend) {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 8.0;
  StoredTableWriter<Surface> writer(surface);
  for (const double x_m : {9.0, 1.0}) {
    SurfacePatch patch;
    patch.centre_m.x() = x_m;
    patch.key = cell_key(patch.centre_m, surface.cell_m);
    patch.half_side_m = 0.3;
    surface.patches = {patch};
    ASSERT_TRUE(writer.append(surface));
  }
  EXPECT_EQ(failure_of(validate(*writer.take())).place, "tile 0, 0");
}

}  // namespace
}  // namespace sightline
