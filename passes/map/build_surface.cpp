#include "passes/map/build_surface.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/tables/stored_table_writer.h"
#include "passes/map/surface/ground_gaps.h"
#include "passes/map/surface/patch_evidence.h"
#include "passes/map/surface/surface_candidates.h"
#include "passes/map/surface/surface_tile.h"
#include "passes/map/tiles/cell_tiles.h"
#include "passes/pass/work_in_parts.h"

// Between two points a surface may go on or have a hole. So each patch is laid through the points
// of a cell and cut into squares, and of each square the returns and the rays that went through and
// on are counted. Rays decide where there were any; elsewhere a patch is solid between its returns.

namespace sightline {
namespace {

// Over all scans that show where rays went; in steps, so that one more drive seldom makes the
// surface of a whole map another one.
double returns_per_ray(const SurfacePoints& points, std::span<const ScanExtent> extents) {
  if (points.scans.empty() || !points.store->has_origins()) return 1.0;
  CountedSights all;
  for (const ScanExtent& extent : extents.first(points.scans.size())) {
    const CountedSights of_scan = counted_sights(extent.point_count);
    all.returns += of_scan.returns;
    all.rays += of_scan.rays;
  }
  constexpr double kSteps = 16.0;
  if (all.rays == 0) return 1.0;
  return std::round(kSteps * static_cast<double>(all.returns) / static_cast<double>(all.rays)) /
         kSteps;
}

Result<CellTally> add_patches(const PassContext& ctx, const BuildSurfaceOptions& options,
                              const SurfacePoints& points, PatchesByTile& patches) {
  const BlockGrid blocks = blocks_of_tiles(options.cell_m, kLongestCell_cells);
  SIGHTLINE_ASSIGN(std::vector<ScanExtent> extents,
                   measure_extents(ctx, points, blocks, "build-surface"));
  const SurfaceTileOptions of_tile{options.cell_m, options.tile_m, options.min_points,
                                   returns_per_ray(points, extents)};
  const CellTiles tiles(std::move(extents), blocks);
  std::vector<CellTally> cells(tiles.size());
  RecordWork<SurfaceTile> work;
  work.count = tiles.size();
  work.content = [&](std::size_t tile) { return content_of_tile(points, of_tile, tiles, tile); };
  work.make = [&](std::size_t tile, int threads) {
    return surface_of_tile(points, of_tile, tiles, tile, threads);
  };
  work.take = [&](std::size_t tile, SurfaceTile found) {
    const Surface surface{{}, options.cell_m, options.tile_m, std::move(found.patches)};
    if (!validate(surface)) return false;
    cells[tile] = found.cells;
    patches.add(surface.patches);
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(after_extents(ctx, points), work));
  CellTally sum;
  for (const CellTally& of_one : cells) sum += of_one;
  return sum;
}

// Level patches in the order of candidates, which decides between ground that is equally near.
std::vector<SurfacePatch> ground_of(const std::vector<SurfacePatch>& patches,
                                    const Surface& surface) {
  std::vector<std::pair<CandidateOrder, std::size_t>> order;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (is_ground(patches[i])) order.emplace_back(candidate_order_of(patches[i], surface), i);
  }
  std::ranges::sort(order);
  std::vector<SurfacePatch> ground;
  ground.reserve(order.size());
  for (const auto& [place, i] : order) ground.push_back(patches[i]);
  return ground;
}

// The patches of a tile, with the ground between ground that lies in it. Error: cannot-read.
Result<std::vector<SurfacePatch>> finished_tile(const PatchesByTile& patches, const TileKey& tile,
                                                const Surface& surface) {
  const Eigen::Vector2d low_m(tile.x * surface.tile_m, tile.y * surface.tile_m);
  const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(kReachOfGround_cells * surface.cell_m);
  const Eigen::Vector2d high_m = low_m + Eigen::Vector2d::Constant(surface.tile_m);
  SIGHTLINE_ASSIGN(const std::vector<SurfacePatch> near,
                   patches.over({low_m - reach_m, high_m + reach_m}));
  SIGHTLINE_ASSIGN(std::vector<SurfacePatch> finished, patches.of_tile(tile));
  for (const SurfacePatch& between : ground_between(ground_of(near, surface), surface.cell_m)) {
    if (tile_of(between.key, surface.cell_m, surface.tile_m) == tile) finished.push_back(between);
  }
  sort_patches(surface, finished);
  return finished;
}

Result<void> write_tiles(const PassContext& ctx, const PatchesByTile& patches,
                         std::span<const TileKey> tiles, const Surface& surface,
                         StoredTableWriter<Surface>& writer) {
  const std::size_t at_once = 4 * static_cast<std::size_t>(threads_each(ctx.threads, 1));
  for (std::size_t first = 0; first < tiles.size(); first += at_once) {
    const std::span<const TileKey> some =
        tiles.subspan(first, std::min(at_once, tiles.size() - first));
    std::vector<Result<std::vector<SurfacePatch>>> finished(some.size(),
                                                            std::vector<SurfacePatch>{});
    parallel_for(some.size(), ctx.threads,
                 [&](std::size_t i) { finished[i] = finished_tile(patches, some[i], surface); });
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (!finished[i]) return finished[i].error();
      Surface of_tile = surface;
      of_tile.patches = *std::move(finished[i]);
      SIGHTLINE_TRY(writer.append(of_tile));
    }
  }
  return {};
}

// Tiles that hold patches, and those beside them into which ground between ground may reach.
std::set<TileKey> tiles_around(const std::vector<TileKey>& tiles, const Surface& surface) {
  const auto rings =
      static_cast<std::int32_t>(std::ceil(kReachOfGround_cells * surface.cell_m / surface.tile_m));
  std::set<TileKey> around;
  for (const TileKey& tile : tiles) {
    for (std::int32_t x = tile.x - rings; x <= tile.x + rings; ++x) {
      for (std::int32_t y = tile.y - rings; y <= tile.y + rings; ++y) around.insert({x, y});
    }
  }
  return around;
}

}  // namespace

std::vector<OptionField> option_fields(BuildSurfaceOptions& options) {
  return {number("cell_m", options.cell_m, "edge length of a surface cell, m", 0.05, 10.0),
          shared(number("tile_m", options.tile_m,
                        "edge length of a map tile, m; a multiple of the cell", 1.0, 10000.0)),
          integer("min_points", options.min_points, "least points of a surface patch", 3, 1000000)};
}

Result<TiledSurface> build_surface(PassContext& ctx, const BuildSurfaceOptions& options,
                                   const SurfacePoints& points) {
  if (!is_tiling(options.cell_m, options.tile_m)) {
    return Error{ErrorCode::kBadValue,
                 concat("tile_m is ", std::to_string(options.tile_m),
                        ", expected a multiple of cell_m ", std::to_string(options.cell_m)),
                 "", "pass build-surface"};
  }
  const Surface order{points.frame, options.cell_m, options.tile_m, {}};
  PatchesByTile patches(options.cell_m, options.tile_m);
  SIGHTLINE_ASSIGN(const CellTally cells, add_patches(ctx, options, points, patches));
  SIGHTLINE_TRY(patches.finish());
  warn_of_invalid_cells(ctx, cells, 2);
  StoredTableWriter<Surface> writer(order);
  const std::set<TileKey> around = tiles_around(patches.tiles(), order);
  const std::vector<TileKey> tiles(around.begin(), around.end());
  SIGHTLINE_TRY(write_tiles(ctx, patches, tiles, order, writer));
  SIGHTLINE_ASSIGN(TiledSurface surface, writer.take());
  if (surface.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap,
                 concat("none of ", cells.valid, " cells has ", options.min_points,
                        " points that stay after moving objects are removed"),
                 "", "pass build-surface"};
  }
  return surface;
}

}  // namespace sightline
