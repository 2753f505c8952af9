#include "passes/build_ndt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "compiler/base/check.h"
#include "compiler/base/parallel.h"

// How a cell gets the same bits for any number of threads: points are cut into chunks of fixed
// size, each chunk sorts its point indices by tile without changing their order, and each tile then
// adds its points chunk by chunk. So every cell adds its points in the order of the input, and
// tiles are independent of each other.

namespace sightline {
namespace {

constexpr std::size_t kChunkSize = 1 << 16;
constexpr double kLeastExtent_m2 = 1e-6;  // largest eigenvalue of a valid cell
constexpr double kGridReach_cells = 0x1.0p30;

// Moments about the cell's centre: far from the origin they keep the digits that matter.
struct CellSums {
  CellKey key;
  std::uint32_t count = 0;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  void add(const Eigen::Vector3d& from_centre_m) {
    const double x = from_centre_m.x();
    const double y = from_centre_m.y();
    const double z = from_centre_m.z();
    ++count;
    sum_m += from_centre_m;
    xx += x * x;
    xy += x * y;
    xz += x * z;
    yy += y * y;
    yz += y * z;
    zz += z * z;
  }
};

// Cells of one tile by key: open addressing over indices into `cells`.
class CellTable {
 public:
  CellTable() : slots_(kFirstSize, kFree) {}

  CellSums& at(const CellKey& key) {
    // Neighbours in a scan often share a cell.
    if (last_ < cells_.size() && cells_[last_].key == key) return cells_[last_];
    std::size_t slot = hash(key) & (slots_.size() - 1);
    while (slots_[slot] != kFree && cells_[slots_[slot]].key != key) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (slots_[slot] == kFree) {
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
      cells_.emplace_back().key = key;
      last_ = cells_.size() - 1;
      if (2 * cells_.size() > slots_.size()) grow();
    } else {
      last_ = slots_[slot];
    }
    return cells_[last_];
  }

  // Ascending by key.
  std::vector<CellSums> take() {
    std::sort(cells_.begin(), cells_.end(),
              [](const CellSums& a, const CellSums& b) { return a.key < b.key; });
    return std::move(cells_);
  }

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t kFirstSize = 1024;

  static std::size_t hash(const CellKey& key) {
    const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                                static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                                static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
    return static_cast<std::size_t>(mixed >> 32);
  }

  void grow() {
    slots_.assign(2 * slots_.size(), kFree);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      std::size_t slot = hash(cells_[i].key) & (slots_.size() - 1);
      while (slots_[slot] != kFree) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<CellSums> cells_;
  std::vector<std::uint32_t> slots_;
  std::size_t last_ = 0;
};

// Point indices of one chunk, grouped by tile, input order kept within a group.
struct ChunkOrder {
  struct Group {
    TileKey tile;
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  std::vector<Group> groups;
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
  for (ChunkOrder::Group& group : order.groups) {
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

// The computed mean may round onto a face of its cell.
double inside_cell(double mean_m, std::int32_t key, double cell_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (floor_to_int(mean_m / cell_m) > key) mean_m = (key + 1.0) * cell_m;
  if (floor_to_int(mean_m / cell_m) < key) mean_m = key * cell_m;
  while (floor_to_int(mean_m / cell_m) > key) mean_m = std::nextafter(mean_m, -kInfinity);
  while (floor_to_int(mean_m / cell_m) < key) mean_m = std::nextafter(mean_m, kInfinity);
  return mean_m;
}

Eigen::Vector3d centre_of(const CellKey& key, double cell_m) {
  return {(key.x + 0.5) * cell_m, (key.y + 0.5) * cell_m, (key.z + 0.5) * cell_m};
}

Nd finish(const CellSums& sums, double cell_m) {
  const double n = sums.count;
  Eigen::Matrix3d outer;
  outer << sums.xx, sums.xy, sums.xz, sums.xy, sums.yy, sums.yz, sums.xz, sums.yz, sums.zz;
  const Eigen::Vector3d from_centre_m = sums.sum_m / n;
  Nd nd;
  nd.key = sums.key;
  nd.point_count = sums.count;
  nd.mean_m = centre_of(sums.key, cell_m) + from_centre_m;
  nd.mean_m.x() = inside_cell(nd.mean_m.x(), sums.key.x, cell_m);
  nd.mean_m.y() = inside_cell(nd.mean_m.y(), sums.key.y, cell_m);
  nd.mean_m.z() = inside_cell(nd.mean_m.z(), sums.key.z, cell_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double moment = outer(i, j) - from_centre_m[i] * sums.sum_m[j];
      nd.covariance_m2(i, j) = nd.covariance_m2(j, i) = moment / (n - 1.0);
    }
  }
  decompose(nd);
  return nd;
}

struct TileNds {
  std::vector<Nd> nds;
  std::uint64_t sparse_cell_count = 0;
  std::uint64_t degenerate_cell_count = 0;
};

// The part of each chunk that lies in one tile, in the order of chunks.
using TileParts = std::vector<std::span<const std::uint64_t>>;

TileNds reduce_tile(std::span<const Eigen::Vector3d> points_m, const TileParts& parts,
                    const BuildNdtOptions& options) {
  CellTable table;
  for (const std::span<const std::uint64_t> part : parts) {
    for (const std::uint64_t index : part) {
      const Eigen::Vector3d& point_m = points_m[index];
      const CellKey key = cell_key(point_m, options.cell_m);
      table.at(key).add(point_m - centre_of(key, options.cell_m));
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
    const Nd nd = finish(sums, options.cell_m);
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
  const std::size_t chunk_count = (points_m.size() + kChunkSize - 1) / kChunkSize;
  const std::vector<ChunkOrder> chunks =
      parallel_map<ChunkOrder>(chunk_count, threads, [&](std::size_t i) {
        const std::size_t end = std::min(points_m.size(), (i + 1) * kChunkSize);
        return order_chunk(points_m, i * kChunkSize, end, options);
      });
  std::map<TileKey, TileParts> parts_by_tile;
  for (const ChunkOrder& chunk : chunks) {
    for (const ChunkOrder::Group& group : chunk.groups) {
      parts_by_tile[group.tile].push_back(
          std::span(chunk.indices).subspan(group.begin, group.end - group.begin));
    }
  }
  std::vector<const TileParts*> tiles;
  for (const auto& [tile, parts] : parts_by_tile) tiles.push_back(&parts);
  std::vector<TileNds> reduced = parallel_map<TileNds>(tiles.size(), threads, [&](std::size_t i) {
    return reduce_tile(points_m, *tiles[i], options);
  });
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
