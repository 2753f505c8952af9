#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_index.h"
#include "formats/grid/cell_moments.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/match_grid.h"

// What odometry matches scans to; part of estimate-trajectory.

namespace sightline {

// What an ND says of a point beside it: as much as its cell's surface holds it, and no more.
Eigen::Matrix3d surface_information_per_m2(const Nd& nd);

// NDs with walls as thin as they are seen, for the last centimetre. The grid is made when it is
// first asked for: scans that given poses lead never do. Safe from several threads.
class SharpGrid {
 public:
  explicit SharpGrid(NdtMap nds) : nds_(std::move(nds)) {}
  [[nodiscard]] const MatchGrid& grid() const;

 private:
  NdtMap nds_;
  mutable std::once_flag once_;
  mutable MatchGrid grid_;
};

// NDs of the same points in cells of 2 m, which draw from afar, and of 1 m; those once more, sharp.
struct LocalGrids {
  MatchGrid coarse;
  MatchGrid fine;
  std::shared_ptr<const SharpGrid> sharp = std::make_shared<const SharpGrid>(NdtMap{});
};
LocalGrids local_grids(const std::vector<Eigen::Vector3d>& points_m);

// Sums of cells that points come to and go from again.
class RollingCells {
 public:
  explicit RollingCells(double cell_m) : cell_m_(cell_m) {}

  // Sign 1 adds points, -1 takes away points that were added before.
  void add(const std::vector<Eigen::Vector3d>& points_m, double sign);
  // Of the cells that hold enough of them; only cells that changed since the last time are
  // computed anew.
  NdtMap nds();

 private:
  struct Cell {
    CellKey key;
    CellMoments moments;
    Nd nd;
    bool is_changed = true;
  };
  Cell& cell_of(const Eigen::Vector3d& point_m);
  void forget_empty_cells();

  double cell_m_;
  std::vector<Cell> cells_;  // by their number in the index
  CellIndex index_;
  std::uint32_t last_ = 0;  // neighbours in a scan often share a cell
};

// The latest key scans, in the map frame.
class LocalMap {
 public:
  explicit LocalMap(double reach_m);

  // Points of a scan in its own frame; those of scans more than the reach ago are forgotten.
  void add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar, double driven_m);
  // Whether a scan here would add to what is known.
  [[nodiscard]] bool wants(const Pose& T_map_lidar) const;
  [[nodiscard]] const LocalGrids& grids() const { return grids_; }

 private:
  struct KeyScan {
    double driven_m = 0.0;
    std::vector<Eigen::Vector3d> points_m;
  };
  double reach_m_;
  std::deque<KeyScan> scans_;
  RollingCells coarse_;
  RollingCells fine_;
  LocalGrids grids_;
  Pose T_map_last_ = Pose::Identity();
};

}  // namespace sightline
