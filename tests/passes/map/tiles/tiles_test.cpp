#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cstddef>

#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "passes/map/surface/ground_gaps.h"
#include "passes/map/surface/patch_evidence.h"
#include "passes/map/surface/surface_candidates.h"
#include "passes/map/tiles/cell_tiles.h"
#include "tests/passes/map/tiles/long_street.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

// Passes that go tile by tile, beside the same on the whole street at once.

namespace sightline {
namespace {

const SurfacePoints& street() {
  static const SurfacePoints kStreet = long_street(1);
  return kStreet;
}

Surface whole_surface(const SurfacePoints& points, const BuildSurfaceOptions& options) {
  const NdtMap cells =
      ndt_from_points(standing_m(points), points.frame, {options.cell_m, options.tile_m, 2}, 1);
  const std::vector<SurfaceCandidate> candidates =
      surface_candidates(cells, static_cast<std::uint32_t>(options.min_points));
  std::vector<SurfacePatch> patches;
  for (const SurfaceCandidate& candidate : candidates) patches.push_back(candidate.patch);
  const PatchGrid grid(patches, cells.cell_m);
  PatchEvidence evidence(grid, patches.size());
  const SurfacePointReader reader(points);
  CountedSights all;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SeenScan scan{*reader.all(part)};
    scan.has_origin = part < points.scans.size();
    if (scan.has_origin) {
      scan.origin_m = points.scans[part].T_map_lidar.translation();
      const CountedSights counted = counted_sights(scan.returns.points_m.size());
      all.returns += counted.returns;
      all.rays += counted.rays;
    }
    evidence.add(std::span(&scan, 1), 1);
  }
  evidence.finish(1);
  const double returns_per_ray =
      all.rays == 0
          ? 1.0
          : std::round(16.0 * static_cast<double>(all.returns) / static_cast<double>(all.rays)) /
                16.0;
  Surface surface{points.frame, options.cell_m, options.tile_m, {}};
  surface.patches = solid_patches(candidates, grid, evidence, returns_per_ray);
  const std::vector<SurfacePatch> between = ground_between(surface.patches, cells.cell_m);
  surface.patches.insert(surface.patches.end(), between.begin(), between.end());
  std::ranges::sort(surface.patches, {},
                    [&](const SurfacePatch& patch) { return order_of(patch, surface); });
  return surface;
}

TEST(TiledNdt, HasTheBytesOfTheWholeAtOnce) {
  for (const BuildNdtOptions& options : {BuildNdtOptions{}, BuildNdtOptions{0.5, 10.0, 3}}) {
    const std::vector<std::byte> whole =
        to_bytes(ndt_from_points(standing_m(street()), street().frame, options, 1));
    for (const int threads : {1, 3}) {
      const NdtMap map = value_of(whole_rows(build_ndt(TestContext(threads), options, street())));
      EXPECT_TRUE(to_bytes(map) == whole);
    }
  }
}

TEST(TiledSurface, HasTheBytesOfTheWholeAtOnce) {
  const auto expect_same = [](const BuildSurfaceOptions& options, int threads) {
    const Surface surface =
        value_of(whole_rows(build_surface(TestContext(threads), options, street())));
    EXPECT_GT(surface.patches.size(), 5000U);
    EXPECT_TRUE(to_bytes(surface) == to_bytes(whole_surface(street(), options)));
  };
  expect_same({}, 3);
  expect_same({1.0, 64.0, 3}, 1);
}

TEST(TiledSurface, CountsRaysThroughATileInWhichTheyDoNotEnd) {
  // A wall 2 m inside a tile is seen by one scan; of two others all rays go on through the whole
  // tile.
  std::vector<Scan> scans(3);
  SurfacePoints points;
  for (std::uint32_t i = 0; i < 3; ++i) {
    Pose T_map_lidar = Pose::Identity();
    T_map_lidar.translation() = Eigen::Vector3d(108.0, 10.0, 0.0);
    points.scans.push_back({i, T_map_lidar, 1.0, 1000.0, 0});
    for (double y_m = -1.0; y_m < 1.0; y_m += 0.04) {
      for (double z_m = -1.0; z_m < 1.0; z_m += 0.04) {
        scans[i].points_m.emplace_back((i == 0 ? 1.0 : 15.0) * Eigen::Vector3d(22.1, y_m, z_m));
      }
    }
  }
  points.store = memory_scan_store(std::move(scans));
  const Surface surface = value_of(whole_rows(build_surface(TestContext(), {}, points)));
  EXPECT_TRUE(to_bytes(surface) == to_bytes(whole_surface(points, {})));
  const auto is_of_wall = [](const SurfacePatch& patch) { return patch.centre_m.x() < 138.0; };
  EXPECT_LT(std::ranges::count_if(surface.patches, is_of_wall), 5) << "of 20";
}

TEST(TiledSurface, ChoosesBetweenEquallyNearGroundAsTheWholeDoes) {
  // Two levels a metre apart, five columns between them, on both sides of the edge of a tile.
  SurfacePoints points;
  for (double y_m = 0.05; y_m < 6.0; y_m += 0.1) {
    for (double x_m = 116.05; x_m < 126.0; x_m += 0.1) points.points_m.emplace_back(x_m, y_m, 0.1);
    for (double x_m = 131.05; x_m < 138.0; x_m += 0.1) points.points_m.emplace_back(x_m, y_m, 1.1);
  }
  const Surface surface = value_of(whole_rows(build_surface(TestContext(), {}, points)));
  EXPECT_TRUE(to_bytes(surface) == to_bytes(whole_surface(points, {})));
}

TEST(TiledSurface, IsTheSameWhoeverMadeItsParts) {
  const BuildSurfaceOptions options{1.0, 64.0, 3};
  const std::vector<std::byte> alone_bytes =
      to_bytes(*whole_rows(build_surface(TestContext(), options, street())));
  NumberedParts kept;
  PassContext second = kept.context(2, {1, 2});
  EXPECT_TRUE(to_bytes(*whole_rows(build_surface(second, options, street()))) == alone_bytes);
  EXPECT_EQ(kept.parts.size(), kept.count);
  EXPECT_GT(kept.count, 4U);
  kept.parts.erase(kept.count - 1);
  kept.parts.erase(0);
  PassContext first = kept.context(1, {0, 2});
  EXPECT_TRUE(to_bytes(*whole_rows(build_surface(first, options, street()))) == alone_bytes);
  EXPECT_EQ(kept.parts.size(), kept.count);
}

TEST(TiledNdt, IsTheSameWhoeverMadeItsParts) {
  const std::vector<std::byte> whole =
      to_bytes(*whole_rows(build_ndt(TestContext(), {}, street())));
  NumberedParts kept;
  for (const std::size_t number : {1U, 0U}) {
    PassContext ctx = kept.context(1, {number, 2});
    EXPECT_TRUE(to_bytes(*whole_rows(build_ndt(ctx, {}, street()))) == whole);
    EXPECT_EQ(kept.parts.size(), kept.count);
    kept.parts.erase(kept.count / 2);
  }
}

// The last scan of the street was somewhere else by a centimetre.
TEST(TiledNdt, AndSurfaceMakeOnlyTheTilesAnewThatAChangeReaches) {
  SurfacePoints moved = street();
  moved.scans.back().T_map_lidar.translation().y() += 0.01;
  const auto expect_few_made = [&](const auto& build) {
    KeptParts kept;
    PassContext first = kept.context();
    (void)build(first, street());
    const std::size_t all = kept.made().size();
    EXPECT_EQ(all, kept.count());
    PassContext second = kept.context();
    const std::vector<std::byte> after = build(second, moved);
    EXPECT_GT(kept.made().size(), 0U);
    EXPECT_LT(kept.made().size(), all);
    EXPECT_TRUE(after == build(TestContext(), moved));
  };
  expect_few_made([](PassContext& ctx, const SurfacePoints& points) {
    return to_bytes(*whole_rows(build_ndt(ctx, {}, points)));
  });
  expect_few_made([](PassContext& ctx, const SurfacePoints& points) {
    return to_bytes(*whole_rows(build_surface(ctx, {1.0, 64.0, 3}, points)));
  });
}

// Some voxels have not moved after all: what scans reach is as it was, and one tile is not.
TEST(TiledNdt, AndSurfaceMakeTheTileAnewInWhichVoxelsMoved) {
  SurfacePoints changed = street();
  EXPECT_GT(std::erase_if(changed.moved_voxels,
                          [](const CellKey& voxel) {
                            const Eigen::Vector3d at_m = cell_centre_m(voxel, street().voxel_m);
                            return std::abs(at_m.x()) < 100.0 && at_m.y() < 103.5;
                          }),
            5U);
  const auto expect_one_made = [&](const auto& build) {
    KeptParts kept;
    PassContext first = kept.context();
    const std::vector<std::byte> before = build(first, street());
    PassContext second = kept.context();
    const std::vector<std::byte> after = build(second, changed);
    EXPECT_EQ(kept.made().size(), 1U);
    EXPECT_FALSE(after == before);
    EXPECT_TRUE(after == build(TestContext(), changed));
  };
  expect_one_made([](PassContext& ctx, const SurfacePoints& points) {
    return to_bytes(*whole_rows(build_ndt(ctx, {2.0, 64.0, 3}, points)));
  });
  expect_one_made([](PassContext& ctx, const SurfacePoints& points) {
    return to_bytes(*whole_rows(build_surface(ctx, {}, points)));
  });
}

TEST(CellTiles, KnowsWhichScansHavePointsOverATile) {
  const BlockGrid blocks = blocks_of_tiles(2.0);
  const std::vector<ScanExtent> extents =
      value_of(measure_extents(TestContext(), street(), blocks, "build-ndt"));
  const CellTiles tiles(extents, blocks);
  const SurfacePointReader reader(street());
  std::uint64_t held = 0;
  std::size_t opened = 0;
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    const std::vector<std::size_t> over = tiles.parts_over(tiles.box(tile));
    EXPECT_TRUE(std::ranges::is_sorted(over));
    EXPECT_FALSE(over.empty());
    opened += over.size();
    for (std::size_t part = 0; part < reader.part_count(); ++part) {
      const std::vector<Eigen::Vector3d> points_m = *reader.standing(part);
      const auto count = std::ranges::count_if(points_m, [&](const Eigen::Vector3d& point_m) {
        return tiles.box(tile).holds(cell_key(point_m, 2.0));
      });
      held += static_cast<std::uint64_t>(count);
      EXPECT_TRUE(count == 0 || std::ranges::binary_search(over, part));
    }
  }
  EXPECT_EQ(held, standing_m(street()).size()) << "tiles hold each point once";
  EXPECT_LT(opened, reader.part_count() * tiles.size());
}

TEST(SurfacePointReader, ReadsSomePartsAsTheWholeDoes) {
  const SurfacePointReader whole(street());
  const std::vector<std::size_t> parts = {3, 4, 30};
  const SurfacePointReader some(street(), parts);
  for (const std::size_t part : parts) {
    EXPECT_EQ(*some.standing(part), *whole.standing(part));
    EXPECT_EQ(*some.moving(part), *whole.moving(part));
    EXPECT_FALSE(whole.moving(part)->empty());
  }
}

TEST(SurfacePointReader, ToldWhereItIsAskedReadsThatPartOfThePlaneAsTheWholeDoes) {
  const SurfacePointReader whole(street());
  const std::vector<std::size_t> parts = {3, 4, 30};
  Eigen::AlignedBox2d within_m;
  for (const CellKey& voxel : street().moved_voxels) {
    within_m.extend(cell_centre_m(voxel, street().voxel_m).head<2>());
  }
  within_m = {within_m.min(), within_m.center()};  // some of what moved lies beyond
  const SurfacePointReader reader(street(), parts, within_m);
  std::size_t moved = 0;
  const auto is_within = [&](const Eigen::Vector3d& point_m) {
    return within_m.contains(point_m.head<2>());
  };
  for (const std::size_t part : parts) {
    std::array<std::vector<Eigen::Vector3d>, 2> asked = {*reader.standing(part),
                                                         *reader.moving(part)};
    std::array<std::vector<Eigen::Vector3d>, 2> expected = {*whole.standing(part),
                                                            *whole.moving(part)};
    EXPECT_LT(asked[0].size(), expected[0].size());
    EXPECT_LE(asked[1].size(), expected[1].size());
    for (std::size_t kind = 0; kind < 2; ++kind) {
      for (auto* points_m : {&asked[kind], &expected[kind]}) {
        std::erase_if(*points_m, [&](const auto& point_m) { return !is_within(point_m); });
      }
      EXPECT_EQ(asked[kind], expected[kind]);
    }
    moved += expected[1].size();
    const ReturnsInMap all = *reader.all(part);
    EXPECT_EQ(all.points_m, whole.all(part)->points_m) << "all returns, wherever they lie";
  }
  EXPECT_GT(moved, 0U);
}

TEST(MeasureExtents, RefusesAPointThatTheGridCannotHoldWhereItLies) {
  SurfacePoints points = street();
  points.points_m = {{0.0, 0.0, 0.0}, {0.0, 1e12, 0.0}};
  const std::string expected = "a surface point is not finite or is more than 2^30 cells";
  PassContext ctx;
  const Error near = failure_of(whole_rows(build_ndt(ctx, {}, points)));
  EXPECT_EQ(near.code, ErrorCode::kInvalidArtifact);
  EXPECT_TRUE(near.message.starts_with(expected)) << near.message;
  EXPECT_EQ(failure_of(whole_rows(build_surface(ctx, {}, points))).place, "pass build-surface");
  points = street();
  points.scans[7].T_map_lidar.translation().x() = 1e12;
  const Error far = failure_of(whole_rows(build_ndt(ctx, {}, points)));
  EXPECT_TRUE(far.message.starts_with("a surface point of scan 7 is not finite")) << far.message;
}

TEST(MeasureExtents, SaysWhatReadingAScanSays) {
  struct Unreadable : ScanStore {
    Result<Scan> read(std::size_t) const override { return Error{ErrorCode::kCannotRead, "gone"}; }
  };
  SurfacePoints points = street();
  points.store = std::make_shared<Unreadable>();
  PassContext ctx;
  EXPECT_EQ(build_ndt(ctx, {}, points).error().code, ErrorCode::kCannotRead);
  EXPECT_EQ(build_surface(ctx, {}, points).error().code, ErrorCode::kCannotRead);
}

}  // namespace
}  // namespace sightline
