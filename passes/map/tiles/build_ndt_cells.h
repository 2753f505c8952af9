#pragma once

#include <cstdint>
#include <mutex>
#include <span>

#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/tables/stored_table_writer.h"
#include "passes/pass/pass_context.h"

// Part of build-ndt.

namespace sightline {

// The sums of CellMoments (formats/surroundings/cell_moments.h), about the cell's centre, but
// faster: no point can be taken away, and every x86-64 adds pairs of doubles at once.
struct CellSums {
  Eigen::Array2d x_y = Eigen::Array2d::Zero();
  Eigen::Array2d xx_yy = Eigen::Array2d::Zero();
  Eigen::Array2d xz_yz = Eigen::Array2d::Zero();
  Eigen::Array2d zz_xy = Eigen::Array2d::Zero();
  double z = 0.0;
  std::uint64_t count = 0;

  // One after the other, in their order.
  void add(std::span<const Eigen::Vector3d> points_m, const Eigen::Vector3d& centre_m);
};

// The cells of a map, or of a part of it.
using NdtCells = CellTable<CellSums>;

// Adds the points of each run, in the order of runs. `begin` of a run counts from the first point.
void add_runs(std::span<const Eigen::Vector3d> points_m, std::span<const CellRun> runs,
              double cell_m, NdtCells& cells);

// How cells become NDs, and how these are ordered.
struct NdtGrid {
  double cell_m = 2.0;
  double tile_m = 64.0;
  std::uint64_t min_points = 10;
};

// The map of all cells of the parts, without frame and count of points. The same for any number of
// threads (0: all there are), and for cells in any order.
NdtMap map_of_cells(std::span<const NdtCells> parts, const NdtGrid& grid, int threads);

// What became of the cells that hold points.
struct CellTally {
  std::uint64_t sparse = 0;      // too few points
  std::uint64_t degenerate = 0;  // no extent
  std::uint64_t valid = 0;

  CellTally& operator+=(const CellTally& other) {
    sparse += other.sparse;
    degenerate += other.degenerate;
    valid += other.valid;
    return *this;
  }
};
SIGHTLINE_FIELDS(CellTally, sparse, degenerate, valid)
// Says so where not all are valid.
void warn_of_invalid_cells(const PassContext& ctx, const CellTally& tally, int min_points);

// The ND of a cell of at least two points: covariance divided by n - 1, mean kept inside the cell.
Nd nd_of(const CellKey& key, const CellSums& sums, double cell_m);

// NDs that come in any order and are wanted tile by tile, in memory as far as they are few.
class NdsByTile {
 public:
  NdsByTile(double cell_m, double tile_m,
            std::size_t most_in_memory = StoredTableWriter<NdtMap>::kMostInMemory);

  // Those of a part of the map, of which each cell lies in one part alone; adds up its counts.
  // Safe from several threads. take() returns its errors.
  void add(const NdtMap& part);
  // All, once, after the last add(), in frame and with points as given. Errors: disk-full,
  // cannot-write, cannot-read.
  [[nodiscard]] Result<TiledNds> take(const MapFrame& frame, std::uint64_t point_count);

 private:
  NdtMap head_;
  std::mutex mutex_;
  StoredTableWriter<NdtMap> growing_;  // in the order of add(): a tile may come several times
  Result<void> written_;
};

}  // namespace sightline
