#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"

// The cells of a map, or of a part of it, while points are added to them; part of build-ndt.

namespace sightline {

// The map's own CellMoments, about the cell's centre as well. In pairs, since every x86-64 adds two
// doubles at once.
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

// The ND of a cell of at least two points: covariance divided by n - 1, mean kept inside the cell.
Nd nd_of(const CellKey& key, const CellSums& sums, double cell_m);

}  // namespace sightline
