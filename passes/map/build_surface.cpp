#include "passes/map/build_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "passes/map/surface/ground_gaps.h"
#include "passes/map/surface/patch_evidence.h"
#include "passes/map/surface/surface_candidates.h"
#include "passes/map/surface/surface_tile.h"
#include "passes/map/tiles/scan_extents.h"
#include "passes/map/tiles/tile_cells.h"
#include "passes/pass/work_in_parts.h"

// Points alone do not say where a surface ends: between two of them it may go on, or have a hole
// that rays go through. So each patch is laid through the points of a cell and cut into squares,
// and of each square it is counted how many returns lie there and how many rays went through it and
// on. Rays decide where there were any; elsewhere a patch is solid between its returns, which the
// scan lines leave apart, and nowhere beyond them.

namespace sightline {
namespace {

std::vector<std::byte> to_bytes(const SurfaceTile& tile, const SurfaceTileOptions& options) {
  ByteWriter writer;
  writer.put(tile.cells.sparse);
  writer.put(tile.cells.degenerate);
  writer.put(tile.cells.valid);
  encode(Surface{{}, options.cell_m, options.tile_m, tile.patches}, writer);
  return writer.take();
}

std::optional<SurfaceTile> surface_tile_of(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  SurfaceTile tile;
  reader.get(tile.cells.sparse);
  reader.get(tile.cells.degenerate);
  reader.get(tile.cells.valid);
  Surface surface;
  decode(reader, surface);
  if (!reader.at_end() || !validate(surface)) return std::nullopt;
  tile.patches = std::move(surface.patches);
  return tile;
}

// Over all scans that tell where rays went; told in steps, so that one more drive seldom makes the
// surface of a whole map another one.
double returns_per_ray(const SurfacePoints& points, std::span<const ScanExtent> extents) {
  if (points.scans.empty() || !points.store->has_origins()) return 1.0;
  CountedSights all;
  for (const ScanExtent& extent : extents.first(points.scans.size())) {
    const CountedSights of_scan = counted_sights(extent.standing_count);
    all.returns += of_scan.returns;
    all.rays += of_scan.rays;
  }
  constexpr double kSteps = 16.0;
  if (all.rays == 0) return 1.0;
  return std::round(kSteps * static_cast<double>(all.returns) / static_cast<double>(all.rays)) /
         kSteps;
}

// Errors: what reading a scan says, invalid-artifact.
Result<std::vector<SurfaceTile>> tiles_of(const PassContext& ctx,
                                          const BuildSurfaceOptions& options,
                                          const SurfacePoints& points) {
  const BlockGrid blocks = blocks_of_tiles(options.cell_m, kLongestCell_cells);
  SIGHTLINE_ASSIGN(std::vector<ScanExtent> extents,
                   measure_extents(ctx, points, blocks, "build-surface"));
  const SurfaceTileOptions of_tile{options.cell_m, options.tile_m, options.min_points,
                                   returns_per_ray(points, extents)};
  const CellTiles tiles(std::move(extents), blocks);
  std::vector<SurfaceTile> made(tiles.size());
  PartedWork work;
  work.count = tiles.size();
  const int threads = threads_each(ctx.threads, work.count);
  work.content = [&](std::size_t tile) { return content_of_tile(points, of_tile, tiles, tile); };
  work.make = [&](std::size_t tile) -> Result<std::vector<std::byte>> {
    SIGHTLINE_ASSIGN(const SurfaceTile found,
                     surface_of_tile(points, of_tile, tiles, tile, threads));
    return to_bytes(found, of_tile);
  };
  work.take = [&](std::size_t tile, std::span<const std::byte> bytes) {
    std::optional<SurfaceTile> found = surface_tile_of(bytes);
    if (found) made[tile] = *std::move(found);
    return found.has_value();
  };
  SIGHTLINE_TRY(work_in_parts(after_extents(ctx, points), work, ctx.threads));
  return made;
}

// Moves them out of the tiles.
std::vector<SurfacePatch> joined(std::vector<SurfaceTile> tiles) {
  std::size_t count = 0;
  for (const SurfaceTile& tile : tiles) count += tile.patches.size();
  std::vector<SurfacePatch> patches;
  patches.reserve(count);
  for (SurfaceTile& tile : tiles) {
    patches.insert(patches.end(), tile.patches.begin(), tile.patches.end());
    std::vector<SurfacePatch>().swap(tile.patches);
  }
  return patches;
}

// Level patches in the order of candidates, which decides between ground that is equally near.
std::vector<SurfacePatch> ground_of(const Surface& surface) {
  std::vector<std::pair<CandidateOrder, std::size_t>> order;
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    const SurfacePatch& patch = surface.patches[i];
    if (is_ground(patch)) order.emplace_back(candidate_order_of(patch, surface), i);
  }
  std::ranges::sort(order);
  std::vector<SurfacePatch> ground;
  ground.reserve(order.size());
  for (const auto& [place, i] : order) ground.push_back(surface.patches[i]);
  return ground;
}

}  // namespace

std::vector<OptionField> option_fields(BuildSurfaceOptions& options) {
  return {number("cell_m", options.cell_m, "edge of a surface cell, m", 0.05, 10.0),
          shared(number("tile_m", options.tile_m, "edge of a tile, a multiple of the cell, m", 1.0,
                        10000.0)),
          integer("min_points", options.min_points, "points that a patch needs", 3, 1000000)};
}

Result<Surface> build_surface(PassContext& ctx, const BuildSurfaceOptions& options,
                              const SurfacePoints& points) {
  if (!is_tiling(options.cell_m, options.tile_m)) {
    return Error{ErrorCode::kBadValue,
                 "tile_m is " + std::to_string(options.tile_m) +
                     ", expected a multiple of cell_m " + std::to_string(options.cell_m),
                 "", "pass build-surface"};
  }
  SIGHTLINE_ASSIGN(std::vector<SurfaceTile> tiles, tiles_of(ctx, options, points));
  CellTally cells;
  for (const SurfaceTile& tile : tiles) cells += tile.cells;
  warn_of_invalid_cells(ctx, cells, 2);
  Surface surface{points.frame, options.cell_m, options.tile_m, joined(std::move(tiles))};
  const std::vector<SurfacePatch> between = ground_between(ground_of(surface), options.cell_m);
  surface.patches.insert(surface.patches.end(), between.begin(), between.end());
  if (surface.patches.empty()) {
    return Error{ErrorCode::kEmptyMap,
                 "no cell of " + std::to_string(cells.valid) + " holds " +
                     std::to_string(options.min_points) + " points that rays do not pass through",
                 "", "pass build-surface"};
  }
  std::ranges::sort(surface.patches, [&](const SurfacePatch& a, const SurfacePatch& b) {
    return order_of(a, surface) < order_of(b, surface);
  });
  return surface;
}

}  // namespace sightline
