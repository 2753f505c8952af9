#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/cell_moments.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/match_grid.h"

// What odometry matches scans to; part of estimate-trajectory.

namespace sightline {

// What an ND says of a point beside it: as much as its cell's surface holds it, and no more.
Eigen::Matrix3d surface_information_per_m2(const Nd& nd);

// What some points sum up to in one cell.
struct CellPart {
  CellKey key;
  CellMoments moments;
};

// Sums of cells that points come to and go from again, and the NDs of those that hold enough.
class RollingCells {
 public:
  explicit RollingCells(double cell_m) : cell_m_(cell_m), grid_(cell_m) {}

  // Sign 1 adds points, -1 takes away points that were added before.
  void add(const std::vector<CellPart>& parts, double sign);
  // To be called behind the last change: computes anew what changed since the last time.
  void finish();
  [[nodiscard]] const MatchGrid& grid() const { return grid_.grid(); }
  [[nodiscard]] NdtMap nds() const;

 private:
  struct Cell {
    CellKey key;
    CellMoments moments;
    Nd nd;
    bool is_changed = true;
    bool is_valid = false;  // the ND
  };
  void forget_empty_cells();

  double cell_m_;
  std::vector<Cell> cells_;  // by their number in the index
  CellIndex index_;
  RollingMatchGrid grid_;
};

// Points as both grids take them: summed up once, by cell, they come and go without being looked at
// again.
struct GriddedPoints {
  std::vector<CellPart> coarse, fine;
};
GriddedPoints gridded(const std::vector<Eigen::Vector3d>& points_m);

// NDs of the same points in cells of 2 m, which draw from afar, and of 1 m; those once more, sharp.
class LocalGrids {
 public:
  LocalGrids();
  [[nodiscard]] const MatchGrid& coarse() const { return coarse_.grid(); }
  [[nodiscard]] const MatchGrid& fine() const { return fine_.grid(); }
  // With walls as thin as they are seen, for the last centimetre. Made when it is first asked for:
  // scans that given poses lead never do. Safe from several threads.
  [[nodiscard]] const MatchGrid& sharp() const;

  // As of RollingCells.
  void add(const GriddedPoints& points, double sign);
  void finish();

 private:
  struct Sharp {
    std::once_flag once;
    MatchGrid grid;
  };
  RollingCells coarse_;
  RollingCells fine_;
  std::shared_ptr<Sharp> sharp_;  // of fine_ as it is; copies share it until they change
};
LocalGrids local_grids(const std::vector<Eigen::Vector3d>& points_m);

// Whether the vehicle has come so far since the last scan of a local map that another one adds to
// it.
bool is_key_step(const Pose& T_map_last, const Pose& T_map_lidar);

// The latest key scans, in the map frame.
class LocalMap {
 public:
  explicit LocalMap(double reach_m);

  // Points of a scan in its own frame; those of scans more than the reach ago are forgotten.
  void add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar, double driven_m);
  // Whether a scan here would add to what is known.
  [[nodiscard]] bool wants(const Pose& T_map_lidar) const {
    return is_key_step(T_map_last_, T_map_lidar);
  }
  [[nodiscard]] const LocalGrids& grids() const { return grids_; }

 private:
  struct KeyScan {
    double driven_m = 0.0;
    GriddedPoints points;
  };
  double reach_m_;
  std::deque<KeyScan> scans_;
  LocalGrids grids_;
  Pose T_map_last_ = Pose::Identity();
};

}  // namespace sightline
