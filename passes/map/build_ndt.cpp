#include "passes/map/build_ndt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "passes/map/tiles/build_ndt_cells.h"
#include "passes/map/tiles/cell_tiles.h"
#include "passes/pass/work_in_parts.h"

// A cell has the same bits for any number of threads: it belongs to one part of the map, which adds
// its points in the order of the input. In windows of chunks every chunk finds its runs of points
// in one cell for the parts, then every part adds its runs, chunk after chunk: memory grows with
// the cells alone. A recording goes tile by tile instead, and memory does not grow.

namespace sightline {
namespace {

double grid_reach_m(double cell_m) { return 0x1.0p30 * cell_m; }

// Position of the first point that the grid cannot hold, or the number of points.
std::size_t first_outside(std::span<const Eigen::Vector3d> points_m, double cell_m) {
  const auto outside = std::ranges::find_if_not(points_m, [&](const Eigen::Vector3d& point_m) {
    return (point_m.array().abs() < grid_reach_m(cell_m)).all();
  });
  return static_cast<std::size_t>(outside - points_m.begin());
}

// The same question without a branch. Doubles without their sign compare as their bits do, NaN and
// infinity last: the sum below is negative for each coordinate that is out of reach.
bool all_inside(std::span<const Eigen::Vector3d> points_m, double cell_m) {
  constexpr std::int64_t kMagnitude = std::numeric_limits<std::int64_t>::max();
  const std::int64_t least_outside = std::bit_cast<std::int64_t>(grid_reach_m(cell_m));
  const double* x_m = points_m.front().data();
  std::int64_t signs = 0;
  for (std::size_t i = 0; i < 3 * points_m.size(); ++i) {
    signs |= least_outside - 1 - (std::bit_cast<std::int64_t>(x_m[i]) & kMagnitude);
  }
  return signs >= 0;
}

// How work on points in memory is cut (recordings: map_of_scans()); no result depends on it.
struct Cut {
  std::size_t part_count = 1;
  std::size_t chunk_count = 1;    // of a window
  std::size_t chunk_size = 2048;  // points: with their keys they stay in the nearest caches
};

Cut cut_for(int threads) { return threads == 1 ? Cut{} : Cut{32, 32, 16384}; }

// The runs of one chunk, in the order of points. Keeps its memory from window to window.
struct ChunkRuns {
  bool all_inside = true;
  std::vector<CellKey> keys;
  std::vector<CellRun> runs;
  std::size_t run_count = 0;
  std::vector<std::vector<CellRun>> runs_of_part;  // empty where there is one part

  [[nodiscard]] std::span<const CellRun> of_part(std::size_t part) const {
    return runs_of_part.empty() ? std::span(runs).first(run_count)
                                : std::span<const CellRun>(runs_of_part[part]);
  }
};

// The high bits of the hash: the low ones place a cell within its part.
std::size_t part_of(const CellKey& key, std::size_t part_count) {
  return (std::uint64_t{hash_of(key)} * part_count) >> 32;
}

void take_runs(std::span<const Eigen::Vector3d> points_m, double cell_m, std::size_t part_count,
               ChunkRuns& chunk) {
  chunk.all_inside = all_inside(points_m, cell_m);
  if (!chunk.all_inside) return;
  chunk.keys.resize(points_m.size());
  chunk.runs.resize(points_m.size());
  cell_keys(points_m, cell_m, chunk.keys);
  chunk.run_count = find_runs(chunk.keys, chunk.runs);
  if (part_count == 1) return;
  chunk.runs_of_part.resize(part_count);
  for (std::vector<CellRun>& runs : chunk.runs_of_part) runs.clear();
  for (const CellRun& run : std::span(chunk.runs).first(chunk.run_count)) {
    chunk.runs_of_part[part_of(run.key, part_count)].push_back(run);
  }
}

// Adds to the parts of the map, made where there are none. False where the grid cannot hold a
// point.
bool add_points(std::span<const Eigen::Vector3d> points_m, double cell_m, int threads,
                std::vector<NdtCells>& parts) {
  const Cut cut = cut_for(threads);
  if (parts.empty()) parts.resize(cut.part_count);
  std::vector<ChunkRuns> chunks(cut.chunk_count);
  const std::size_t window_size = cut.chunk_count * cut.chunk_size;
  for (std::size_t first = 0; first < points_m.size(); first += window_size) {
    const auto window_m = points_m.subspan(first, std::min(window_size, points_m.size() - first));
    const std::size_t used = (window_m.size() + cut.chunk_size - 1) / cut.chunk_size;
    const auto points_of = [&](std::size_t chunk) {
      const std::size_t begin = chunk * cut.chunk_size;
      return window_m.subspan(begin, std::min(cut.chunk_size, window_m.size() - begin));
    };
    parallel_for(used, threads, [&](std::size_t chunk) {
      take_runs(points_of(chunk), cell_m, cut.part_count, chunks[chunk]);
    });
    if (!std::ranges::all_of(chunks, &ChunkRuns::all_inside)) return false;
    parallel_for(cut.part_count, threads, [&](std::size_t part) {
      for (std::size_t chunk = 0; chunk < used; ++chunk) {
        add_runs(points_of(chunk), chunks[chunk].of_part(part), cell_m, parts[part]);
      }
    });
  }
  return true;
}

NdtGrid grid_of(const BuildNdtOptions& options) {
  return {options.cell_m, options.tile_m,
          static_cast<std::uint64_t>(std::max(options.min_points, 0))};
}

Error outside_grid(std::size_t point) {
  return {
      ErrorCode::kInvalidArtifact,
      concat("surface point ", point, " is not finite or is more than 2^30 cells from the origin"),
      "", "pass build-ndt"};
}

Result<TiledNds> map_of_points(PassContext& ctx, const BuildNdtOptions& options,
                               const SurfacePoints& points) {
  const std::vector<Eigen::Vector3d>& points_m = points.points_m;
  std::vector<NdtCells> parts;
  if (!add_points(points_m, options.cell_m, ctx.threads, parts)) {
    return outside_grid(first_outside(points_m, options.cell_m));
  }
  NdtMap map = map_of_cells(parts, grid_of(options), ctx.threads);
  map.point_count = points_m.size();
  map.frame = points.frame;
  return TiledNds(map);
}

Result<TiledNds> map_of_scans(const PassContext& ctx, const BuildNdtOptions& options,
                              const SurfacePoints& points) {
  const BlockGrid blocks = blocks_of_tiles(options.cell_m);
  SIGHTLINE_ASSIGN(std::vector<ScanExtent> extents,
                   measure_extents(ctx, points, blocks, "build-ndt"));
  const CellTiles tiles(std::move(extents), blocks);
  NdsByTile nds(options.cell_m, options.tile_m);
  PartedWork work;
  work.count = tiles.size();
  work.content = [&](std::size_t tile) {
    const CellBox box = tiles.box(tile);
    return content_of_parts(points, tiles.parts_over(box), extent_m(box, options.cell_m),
                            written(box));
  };
  work.make = [&](std::size_t tile, int threads) -> Result<std::vector<std::byte>> {
    const CellBox box = tiles.box(tile);
    const std::vector<std::size_t> parts = tiles.parts_over(box);
    const SurfacePointReader reader(points, parts, extent_m(box, options.cell_m));
    SIGHTLINE_ASSIGN(const NdtCells cells, cells_over(reader, parts, box, options.cell_m, threads));
    return to_bytes(map_of_cells(std::span(&cells, 1), grid_of(options), threads));
  };
  work.take = [&](std::size_t /*tile*/, std::span<const std::byte> bytes) {
    const Result<NdtMap> map = from_bytes<NdtMap>(bytes);
    if (map) nds.add(*map);
    return map.has_value();
  };
  SIGHTLINE_TRY(work_in_parts(after_extents(ctx, points), work));
  return nds.take(points.frame, points.standing_count + points.points_m.size());
}

}  // namespace

std::vector<OptionField> option_fields(BuildNdtOptions& options) {
  return {number("cell_m", options.cell_m, "edge length of an NDT cell, m", 0.1, 100.0),
          shared(number("tile_m", options.tile_m,
                        "edge length of a map tile, m; a multiple of the cell", 1.0, 10000.0)),
          integer("min_points", options.min_points, "least points of a valid cell", 3, 1000000)};
}

NdtMap ndt_from_points(std::span<const Eigen::Vector3d> points_m, const MapFrame& frame,
                       const BuildNdtOptions& options, int threads) {
  SIGHTLINE_CHECK(is_tiling(options.cell_m, options.tile_m));
  std::vector<NdtCells> parts;
  const bool is_inside = add_points(points_m, options.cell_m, threads, parts);
  SIGHTLINE_CHECK(is_inside);
  NdtMap map = map_of_cells(parts, grid_of(options), threads);
  map.point_count = points_m.size();
  map.frame = frame;
  return map;
}

Result<TiledNds> build_ndt(PassContext& ctx, const BuildNdtOptions& options,
                           const SurfacePoints& points) {
  if (!is_tiling(options.cell_m, options.tile_m)) {
    return Error{ErrorCode::kBadValue,
                 concat("tile_m is ", std::to_string(options.tile_m),
                        ", expected a multiple of cell_m ", std::to_string(options.cell_m)),
                 "", "pass build-ndt"};
  }
  SIGHTLINE_ASSIGN(TiledNds nds, points.scans.empty() ? map_of_points(ctx, options, points)
                                                      : map_of_scans(ctx, options, points));
  const NdtMap& head = nds.head();
  if (nds.row_count() == 0) {
    return Error{
        ErrorCode::kEmptyMap,
        concat("none of ", head.sparse_cell_count + head.degenerate_cell_count, " cells has ",
               options.min_points, " points and an extent: record a longer drive, or raise cell_m"),
        "", "pass build-ndt"};
  }
  warn_of_invalid_cells(ctx, {head.sparse_cell_count, head.degenerate_cell_count, nds.row_count()},
                        options.min_points);
  return nds;
}

}  // namespace sightline
