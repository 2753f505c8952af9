#include "passes/map/tiles/build_ndt_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

constexpr double kLeastExtent_m2 = 1e-6;  // largest eigenvalue of a valid cell
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The computed mean may round onto a face of its cell.
double inside_cell(double mean_m, std::int32_t key, double cell_m) {
  if (floor_to_int(mean_m / cell_m) > key) mean_m = (key + 1.0) * cell_m;
  if (floor_to_int(mean_m / cell_m) < key) mean_m = key * cell_m;
  while (floor_to_int(mean_m / cell_m) > key) mean_m = std::nextafter(mean_m, -kInfinity);
  while (floor_to_int(mean_m / cell_m) < key) mean_m = std::nextafter(mean_m, kInfinity);
  return mean_m;
}

// A cell of enough points, and its place in the order of NDs.
struct FullCell {
  TileKey tile;
  CellKey key;
  const CellSums* sums = nullptr;
};

// Ascending by tile and key; refers to the parts. Counts the others.
std::vector<FullCell> full_cells(std::span<const NdtCells> parts, const NdtGrid& grid,
                                 std::uint64_t& sparse_count) {
  // A covariance needs two points whatever the option says.
  const auto least_count = std::max<std::uint64_t>(grid.min_points, 2);
  std::vector<FullCell> cells;
  for (const NdtCells& part : parts) {
    for (std::size_t i = 0; i < part.keys().size(); ++i) {
      if (part.values()[i].count < least_count) {
        ++sparse_count;
        continue;
      }
      const CellKey& key = part.keys()[i];
      cells.push_back({tile_of(key, grid.cell_m, grid.tile_m), key, &part.values()[i]});
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

}  // namespace

void CellSums::add(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& centre_m) {
  const Eigen::Array2d centre_xy_m = centre_m.head<2>();
  CellSums sums = *this;  // in registers
  for (const Eigen::Vector3d& point_m : points_m) {
    const Eigen::Array2d from_xy_m = point_m.head<2>().array() - centre_xy_m;
    const double from_z_m = point_m.z() - centre_m.z();
    sums.x_y += from_xy_m;
    sums.z += from_z_m;
    sums.xx_yy += from_xy_m * from_xy_m;
    sums.xz_yz += from_xy_m * from_z_m;
    sums.zz_xy += Eigen::Array2d(from_z_m, from_xy_m[0]) * Eigen::Array2d(from_z_m, from_xy_m[1]);
  }
  sums.count += points_m.size();
  *this = sums;
}

void add_runs(std::span<const Eigen::Vector3d> points_m, std::span<const CellRun> runs,
              double cell_m, NdtCells& cells) {
  cells.add(runs, [&](CellSums& sums, const CellRun& run) {
    sums.add(points_m.subspan(run.begin, run.count), cell_centre_m(run.key, cell_m));
  });
}

NdtMap map_of_cells(std::span<const NdtCells> parts, const NdtGrid& grid, int threads) {
  NdtMap map;
  map.cell_m = grid.cell_m;
  map.tile_m = grid.tile_m;
  map.nds = nds_of(full_cells(parts, grid, map.sparse_cell_count), grid.cell_m, threads);
  map.degenerate_cell_count =
      std::erase_if(map.nds, [](const Nd& nd) { return nd.eigenvalues_m2[0] < kLeastExtent_m2; });
  return map;
}

void warn_of_invalid_cells(const PassContext& ctx, const CellTally& tally, int min_points) {
  if (tally.sparse + tally.degenerate == 0) return;
  ctx.inform(concat(tally.sparse, " cells have fewer than ", min_points, " points and ",
                    tally.degenerate, " no extent; ", tally.valid, " cells are valid"));
}

Nd nd_of(const CellKey& key, const CellSums& sums, double cell_m) {
  const double n = static_cast<double>(sums.count);
  const Eigen::Vector3d sum_m(sums.x_y[0], sums.x_y[1], sums.z);
  Eigen::Matrix3d outer;                                 // the upper half
  outer << sums.xx_yy[0], sums.zz_xy[1], sums.xz_yz[0],  //
      0.0, sums.xx_yy[1], sums.xz_yz[1],                 //
      0.0, 0.0, sums.zz_xy[0];
  const Eigen::Vector3d from_centre_m = sum_m / n;
  Nd nd;
  nd.key = key;
  nd.point_count = static_cast<std::uint32_t>(sums.count);
  nd.mean_m = cell_centre_m(key, cell_m) + from_centre_m;
  nd.mean_m.x() = inside_cell(nd.mean_m.x(), key.x, cell_m);
  nd.mean_m.y() = inside_cell(nd.mean_m.y(), key.y, cell_m);
  nd.mean_m.z() = inside_cell(nd.mean_m.z(), key.z, cell_m);
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double moment = outer(i, j) - from_centre_m[i] * sum_m[j];
      nd.covariance_m2(i, j) = nd.covariance_m2(j, i) = moment / (n - 1.0);
    }
  }
  decompose(nd);
  return nd;
}

NdsByTile::NdsByTile(double cell_m, double tile_m, std::size_t most_in_memory)
    : head_{{}, cell_m, tile_m, {}, 0, 0, 0}, growing_(head_, most_in_memory) {}

void NdsByTile::add(const NdtMap& part) {
  const std::lock_guard<std::mutex> lock(mutex_);
  head_.sparse_cell_count += part.sparse_cell_count;
  head_.degenerate_cell_count += part.degenerate_cell_count;
  if (written_) written_ = growing_.append(part);
}

Result<TiledNds> NdsByTile::take(const MapFrame& frame, std::uint64_t point_count) {
  SIGHTLINE_TRY(written_);
  SIGHTLINE_ASSIGN(const TiledNds added, growing_.take());
  std::map<TileKey, std::vector<RowTile>> pieces;
  for (const RowTile& piece : added.tiles()) pieces[piece.key].push_back(piece);
  head_.frame = frame;
  head_.point_count = point_count;
  StoredTableWriter<NdtMap> writer(head_);
  for (const auto& [tile, of_tile] : pieces) {
    NdtMap nds = head_;
    for (const RowTile& piece : of_tile) {
      SIGHTLINE_ASSIGN(const NdtMap some, added.tile(piece));
      nds.nds.insert(nds.nds.end(), some.nds.begin(), some.nds.end());
    }
    std::ranges::sort(nds.nds, {}, &Nd::key);
    SIGHTLINE_TRY(writer.append(nds));
  }
  return writer.take();
}

}  // namespace sightline
