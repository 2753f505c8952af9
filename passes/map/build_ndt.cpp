#include "passes/map/build_ndt.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "passes/map/build_ndt_cells.h"

// How a cell gets the same bits for any number of threads: each cell belongs to one part of the
// map, and a part adds its points in the order of the input. Points pass through in windows of
// chunks: first every chunk finds its runs of points in one cell and hands them to parts, then
// every part adds its runs, chunk after chunk. Nothing that a window needs outlives it, so memory
// grows with the cells and not with the points.

namespace sightline {
namespace {

constexpr double kLeastExtent_m2 = 1e-6;  // largest eigenvalue of a valid cell

bool is_outside(double x_m, double reach_m) { return !(std::abs(x_m) < reach_m); }

double grid_reach_m(double cell_m) { return 0x1.0p30 * cell_m; }

// Position of the first point that the grid cannot hold, or the number of points.
std::size_t first_outside(std::span<const Eigen::Vector3d> points_m, double cell_m) {
  const double reach_m = grid_reach_m(cell_m);
  std::size_t i = 0;
  while (i < points_m.size() && !is_outside(points_m[i].x(), reach_m) &&
         !is_outside(points_m[i].y(), reach_m) && !is_outside(points_m[i].z(), reach_m)) {
    ++i;
  }
  return i;
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

// How work is cut; no result depends on it.
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

// A cell of enough points, and its place in the order of NDs.
struct FullCell {
  TileKey tile;
  CellKey key;
  const CellSums* sums = nullptr;
};

// Ascending by tile and key; refers to the parts. Counts the others.
std::vector<FullCell> full_cells(const std::vector<NdtCells>& parts, const BuildNdtOptions& options,
                                 std::uint64_t& sparse_count) {
  // A covariance needs two points whatever the option says.
  const auto least_count = static_cast<std::uint64_t>(std::max(options.min_points, 2));
  std::vector<FullCell> cells;
  for (const NdtCells& part : parts) {
    for (std::size_t i = 0; i < part.keys().size(); ++i) {
      if (part.sums()[i].count < least_count) {
        ++sparse_count;
        continue;
      }
      const CellKey& key = part.keys()[i];
      cells.push_back({tile_of(key, options.cell_m, options.tile_m), key, &part.sums()[i]});
    }
  }
  std::sort(cells.begin(), cells.end(), [](const FullCell& a, const FullCell& b) {
    return a.tile != b.tile ? a.tile < b.tile : a.key < b.key;
  });
  return cells;
}

std::vector<Nd> nds_of(const std::vector<FullCell>& cells, double cell_m, int threads) {
  constexpr std::size_t kBatch = 256;
  std::vector<Nd> nds(cells.size());
  parallel_for((cells.size() + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
    const std::size_t end = std::min(cells.size(), (batch + 1) * kBatch);
    for (std::size_t i = batch * kBatch; i < end; ++i) {
      nds[i] = nd_of(cells[i].key, *cells[i].sums, cell_m);
    }
  });
  return nds;
}

// The map of `point_count` points that were added.
NdtMap map_of(const std::vector<NdtCells>& parts, std::uint64_t point_count,
              const BuildNdtOptions& options, int threads) {
  NdtMap map;
  map.cell_m = options.cell_m;
  map.tile_m = options.tile_m;
  map.point_count = point_count;
  map.nds = nds_of(full_cells(parts, options, map.sparse_cell_count), options.cell_m, threads);
  map.degenerate_cell_count =
      std::erase_if(map.nds, [](const Nd& nd) { return nd.eigenvalues_m2[0] < kLeastExtent_m2; });
  return map;
}

// The points of parts [first, end) of the drive, in their order. Errors: what reading says.
Result<std::vector<Eigen::Vector3d>> read_scans(const SurfacePointReader& reader, std::size_t first,
                                                std::size_t end, int threads) {
  using Points = Result<std::vector<Eigen::Vector3d>>;
  std::vector<Points> scans(end - first, Points(std::vector<Eigen::Vector3d>()));
  parallel_for(scans.size(), threads,
               [&](std::size_t i) { scans[i] = reader.standing(first + i); });
  std::vector<Eigen::Vector3d> points_m;
  for (const Points& scan : scans) {
    if (!scan) return scan.error();
    points_m.insert(points_m.end(), scan->begin(), scan->end());
  }
  return points_m;
}

// A few scans in memory at a time. Errors: what reading says, invalid-artifact.
Result<NdtMap> map_of_scans(PassContext& ctx, const BuildNdtOptions& options,
                            const SurfacePoints& points) {
  constexpr std::size_t kScansAtOnce = 16;
  const SurfacePointReader reader(points);
  std::vector<NdtCells> parts;
  std::uint64_t count = 0;
  for (std::size_t first = 0; first < reader.part_count(); first += kScansAtOnce) {
    const std::size_t end = std::min(first + kScansAtOnce, reader.part_count());
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> scans_m,
                     read_scans(reader, first, end, ctx.threads));
    if (!add_points(scans_m, options.cell_m, ctx.threads, parts)) {
      const std::uint64_t outside = count + first_outside(scans_m, options.cell_m);
      return Error{ErrorCode::kInvalidArtifact,
                   "surface point " + std::to_string(outside) +
                       " is not finite or lies more than 2^30 cells from the origin",
                   "", "pass build-ndt"};
    }
    count += scans_m.size();
    ctx.progress(end, reader.part_count());
  }
  NdtMap map = map_of(parts, count, options, ctx.threads);
  map.frame = points.frame;
  return map;
}

void warn_of_invalid_cells(const PassContext& ctx, const NdtMap& map, int min_points) {
  if (map.sparse_cell_count + map.degenerate_cell_count == 0) return;
  ctx.warn(std::to_string(map.sparse_cell_count) + " cells have fewer than " +
           std::to_string(min_points) + " points and " + std::to_string(map.degenerate_cell_count) +
           " no extent; " + std::to_string(map.nds.size()) + " cells are valid");
}

}  // namespace

std::vector<OptionField> option_fields(BuildNdtOptions& options) {
  return {number("cell_m", options.cell_m, "edge of an NDT cell, m", 0.1, 100.0),
          shared(number("tile_m", options.tile_m, "edge of a tile, a multiple of the cell, m", 1.0,
                        10000.0)),
          integer("min_points", options.min_points, "points that a valid cell needs", 3, 1000000)};
}

NdtMap ndt_from_points(std::span<const Eigen::Vector3d> points_m, const MapFrame& frame,
                       const BuildNdtOptions& options, int threads) {
  SIGHTLINE_CHECK(is_tiling(options.cell_m, options.tile_m));
  std::vector<NdtCells> parts;
  const bool is_inside = add_points(points_m, options.cell_m, threads, parts);
  SIGHTLINE_CHECK(is_inside);
  NdtMap map = map_of(parts, points_m.size(), options, threads);
  map.frame = frame;
  return map;
}

Result<NdtMap> build_ndt(PassContext& ctx, const BuildNdtOptions& options,
                         const SurfacePoints& points) {
  if (!is_tiling(options.cell_m, options.tile_m)) {
    return Error{ErrorCode::kBadValue,
                 "tile_m is " + std::to_string(options.tile_m) +
                     ", expected a multiple of cell_m " + std::to_string(options.cell_m),
                 "", "pass build-ndt"};
  }
  SIGHTLINE_ASSIGN(NdtMap map, map_of_scans(ctx, options, points));
  if (map.nds.empty()) {
    return Error{ErrorCode::kEmptyMap,
                 "none of " + std::to_string(map.sparse_cell_count + map.degenerate_cell_count) +
                     " cells has " + std::to_string(options.min_points) +
                     " points and an extent: is the drive too short or the cell too small?",
                 "", "pass build-ndt"};
  }
  warn_of_invalid_cells(ctx, map, options.min_points);
  return map;
}

}  // namespace sightline
