#include "passes/build_ndt.h"

#include <algorithm>
#include <map>

#include "compiler/base/check.h"
#include "compiler/base/parallel.h"
#include "passes/build_ndt_cells.h"

// How a cell gets the same bits for any number of threads: points are cut into chunks of fixed
// size, each chunk sorts its point indices by tile without changing their order, and each tile then
// adds its points chunk by chunk. So every cell adds its points in the order of the input, and
// tiles are independent of each other.

namespace sightline {
namespace {

constexpr std::size_t kChunkSize = 1 << 16;
constexpr double kLeastExtent_m2 = 1e-6;  // largest eigenvalue of a valid cell
constexpr double kGridReach_cells = 0x1.0p30;

struct TileGroup {
  TileKey tile;
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Point indices of one chunk, grouped by tile, input order kept within a group.
struct ChunkOrder {
  std::vector<TileGroup> groups;
  std::vector<std::uint64_t> indices;
};

ChunkOrder order_chunk(std::span<const Eigen::Vector3d> points_m, std::size_t begin,
                       std::size_t end, const BuildNdtOptions& options) {
  ChunkOrder order;
  std::vector<std::uint32_t> group_of(end - begin);
  std::map<TileKey, std::uint32_t> group_by_tile;
  std::uint32_t last = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const TileKey tile =
        tile_of(cell_key(points_m[i], options.cell_m), options.cell_m, options.tile_m);
    if (order.groups.empty() || order.groups[last].tile != tile) {
      const auto next = static_cast<std::uint32_t>(order.groups.size());
      last = group_by_tile.try_emplace(tile, next).first->second;
      if (last == next) order.groups.push_back({tile, 0, 0});
    }
    group_of[i - begin] = last;
    ++order.groups[last].end;
  }
  std::size_t offset = 0;
  for (TileGroup& group : order.groups) {
    const std::size_t size = group.end;
    group.begin = offset;
    group.end = offset;  // grows back to its size while the indices are placed
    offset += size;
  }
  order.indices.resize(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    order.indices[order.groups[group_of[i - begin]].end++] = i;
  }
  return order;
}

std::vector<ChunkOrder> order_points(std::span<const Eigen::Vector3d> points_m,
                                     const BuildNdtOptions& options, int threads) {
  const std::size_t chunk_count = (points_m.size() + kChunkSize - 1) / kChunkSize;
  return parallel_map<ChunkOrder>(chunk_count, threads, [&](std::size_t i) {
    const std::size_t end = std::min(points_m.size(), (i + 1) * kChunkSize);
    return order_chunk(points_m, i * kChunkSize, end, options);
  });
}

// The part of each chunk that lies in one tile, in the order of chunks.
using TileParts = std::vector<std::span<const std::uint64_t>>;

// Ascending by tile; refers to the chunks.
std::vector<TileParts> parts_of_tiles(const std::vector<ChunkOrder>& chunks) {
  std::map<TileKey, TileParts> parts_by_tile;
  for (const ChunkOrder& chunk : chunks) {
    for (const TileGroup& group : chunk.groups) {
      parts_by_tile[group.tile].push_back(
          std::span(chunk.indices).subspan(group.begin, group.end - group.begin));
    }
  }
  std::vector<TileParts> tiles;
  for (auto& [tile, parts] : parts_by_tile) tiles.push_back(std::move(parts));
  return tiles;
}

struct TileNds {
  std::vector<Nd> nds;
  std::uint64_t sparse_cell_count = 0;
  std::uint64_t degenerate_cell_count = 0;
};

TileNds reduce_tile(std::span<const Eigen::Vector3d> points_m, const TileParts& parts,
                    const BuildNdtOptions& options) {
  CellTable table;
  for (const std::span<const std::uint64_t> part : parts) {
    for (const std::uint64_t index : part) {
      const Eigen::Vector3d& point_m = points_m[index];
      const CellKey key = cell_key(point_m, options.cell_m);
      table.at(key).add(point_m - cell_centre_m(key, options.cell_m));
    }
  }
  TileNds tile;
  // A covariance needs two points whatever the option says.
  const auto least_count = static_cast<std::uint32_t>(std::max(options.min_points, 2));
  for (const CellSums& sums : table.take()) {
    if (sums.count < least_count) {
      ++tile.sparse_cell_count;
      continue;
    }
    const Nd nd = nd_of(sums, options.cell_m);
    if (nd.eigenvalues_m2[0] >= kLeastExtent_m2) {
      tile.nds.push_back(nd);
    } else {
      ++tile.degenerate_cell_count;
    }
  }
  return tile;
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
  const std::vector<ChunkOrder> chunks = order_points(points_m, options, threads);
  const std::vector<TileParts> tiles = parts_of_tiles(chunks);
  const std::vector<TileNds> reduced = parallel_map<TileNds>(
      tiles.size(), threads,
      [&](std::size_t i) { return reduce_tile(points_m, tiles[i], options); });
  NdtMap map;
  map.frame = frame;
  map.cell_m = options.cell_m;
  map.tile_m = options.tile_m;
  map.point_count = points_m.size();
  for (const TileNds& tile : reduced) {
    map.nds.insert(map.nds.end(), tile.nds.begin(), tile.nds.end());
    map.sparse_cell_count += tile.sparse_cell_count;
    map.degenerate_cell_count += tile.degenerate_cell_count;
  }
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
