#include "passes/build_ndt.h"

#include <algorithm>

#include "compiler/base/check.h"
#include "compiler/base/parallel.h"
#include "passes/build_ndt_cells.h"

// How a cell gets the same bits for any number of threads: each cell belongs to one part of the map,
// and a part adds its points in the order of the input. Points pass through in windows of chunks:
// first every chunk finds its runs of points in one cell and hands them to parts, then every part
// adds its runs, chunk after chunk. Nothing that a window needs outlives it, so memory grows with the
// cells and not with the points.

namespace sightline {
namespace {

constexpr double kLeastExtent_m2 = 1e-6;  // largest eigenvalue of a valid cell
constexpr double kGridReach_cells = 0x1.0p30;

// How work is cut; no result depends on it.
struct Cut {
  std::size_t part_count = 1;
  std::size_t chunk_count = 1;    // of a window
  std::size_t chunk_size = 2048;  // points: with their keys they stay in the nearest caches
};

Cut cut_for(int threads) { return threads == 1 ? Cut{} : Cut{32, 32, 16384}; }

// The runs of one chunk, by part. Keeps its memory from window to window.
struct ChunkRuns {
  std::vector<CellKey> keys;
  std::vector<CellRun> runs;
  std::vector<std::vector<CellRun>> runs_of_part;
};

void find_runs(std::span<const Eigen::Vector3d> points_m, double cell_m, std::size_t part_count,
               ChunkRuns& chunk) {
  chunk.keys.resize(points_m.size());
  cell_keys(points_m, cell_m, chunk.keys);
  chunk.runs_of_part.resize(part_count);
  for (std::vector<CellRun>& runs : chunk.runs_of_part) runs.clear();
  if (part_count == 1) {
    append_runs(chunk.keys, chunk.runs_of_part.front());
    return;
  }
  chunk.runs.clear();
  append_runs(chunk.keys, chunk.runs);
  // The high bits of the hash: the low ones place a cell within its part.
  for (const CellRun& run : chunk.runs) {
    const std::uint64_t part = (std::uint64_t{hash_of(run.key)} * part_count) >> 32;
    chunk.runs_of_part[part].push_back(run);
  }
}

std::vector<CellTable> add_points(std::span<const Eigen::Vector3d> points_m, double cell_m,
                                  int threads) {
  const Cut cut = cut_for(threads);
  std::vector<CellTable> parts(cut.part_count, CellTable(cell_m));
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
      find_runs(points_of(chunk), cell_m, cut.part_count, chunks[chunk]);
    });
    parallel_for(cut.part_count, threads, [&](std::size_t part) {
      for (std::size_t chunk = 0; chunk < used; ++chunk) {
        parts[part].add(points_of(chunk), chunks[chunk].runs_of_part[part]);
      }
    });
  }
  return parts;
}

// A cell of enough points, and its place in the order of NDs.
struct FullCell {
  TileKey tile;
  CellKey key;
  const CellSums* sums = nullptr;
};

// Ascending by tile and key; refers to the parts. Counts the others.
std::vector<FullCell> full_cells(const std::vector<CellTable>& parts,
                                 const BuildNdtOptions& options, std::uint64_t& sparse_count) {
  // A covariance needs two points whatever the option says.
  const auto least_count = static_cast<std::uint64_t>(std::max(options.min_points, 2));
  std::vector<FullCell> cells;
  for (const CellTable& part : parts) {
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

// Position of the first point that the grid cannot hold, or the number of points.
std::size_t first_outside(const std::vector<Eigen::Vector3d>& points_m, double cell_m) {
  const double reach_m = kGridReach_cells * cell_m;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!(points_m[i].cwiseAbs().maxCoeff() < reach_m) || !points_m[i].allFinite()) return i;
  }
  return points_m.size();
}

void warn_of_invalid_cells(const PassContext& ctx, const NdtMap& map, int min_points) {
  if (map.sparse_cell_count + map.degenerate_cell_count == 0) return;
  ctx.warn(std::to_string(map.sparse_cell_count) + " cells have fewer than " +
           std::to_string(min_points) + " points and " + std::to_string(map.degenerate_cell_count) +
           " no extent; " + std::to_string(map.nds.size()) + " cells are valid");
}

}  // namespace

std::vector<OptionField> option_fields(BuildNdtOptions& options) {
  return {
      number("cell_m", options.cell_m, "edge of an NDT cell, m", 0.1, 100.0),
      number("tile_m", options.tile_m, "edge of a tile, a multiple of the cell, m", 1.0, 10000.0),
      integer("min_points", options.min_points, "points that a valid cell needs", 3, 1000000)};
}

NdtMap ndt_from_points(std::span<const Eigen::Vector3d> points_m, const MapFrame& frame,
                       const BuildNdtOptions& options, int threads) {
  SIGHTLINE_CHECK(is_tiling(options.cell_m, options.tile_m));
  NdtMap map;
  map.frame = frame;
  map.cell_m = options.cell_m;
  map.tile_m = options.tile_m;
  map.point_count = points_m.size();
  const std::vector<CellTable> parts = add_points(points_m, options.cell_m, threads);
  map.nds = nds_of(full_cells(parts, options, map.sparse_cell_count), options.cell_m, threads);
  map.degenerate_cell_count = std::erase_if(
      map.nds, [](const Nd& nd) { return nd.eigenvalues_m2[0] < kLeastExtent_m2; });
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
  const std::size_t outside = first_outside(points.points_m, options.cell_m);
  if (outside < points.points_m.size()) {
    return Error{ErrorCode::kInvalidArtifact,
                 "surface point " + std::to_string(outside) +
                     " is not finite or lies more than 2^30 cells from the origin",
                 "", "pass build-ndt"};
  }
  NdtMap map = ndt_from_points(points.points_m, points.frame, options, ctx.threads);
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
