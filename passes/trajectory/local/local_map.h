#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/cell_moments.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/match_grid.h"

// The map that odometry matches scans to, and how much of a scan is found in it; part of
// estimate-trajectory.

namespace sightline {

// The inverse covariance of a point beside an ND: tight across the surface of its cell, loose along
// it.
Eigen::Matrix3d surface_information_per_m2(const Nd& nd);

inline constexpr double kDetailCell_m = 0.5;

// The moments of some points in one cell.
struct CellPart {
  CellKey key;
  CellMoments moments;
};

// Moments of cells to which points are added and removed again, and the NDs of those with enough
// points.
class RollingCells {
 public:
  // `has_grid`: whether its NDs are matched to.
  explicit RollingCells(double cell_m, bool has_grid = true)
      : cell_m_(cell_m), has_grid_(has_grid), grid_(cell_m) {}

  // Sign 1 adds points, -1 removes points that were added before. `way_m`: of the drive, where they
  // were measured.
  void add(const std::vector<CellPart>& parts, double sign, double way_m);
  // To be called after the last change: updates the NDs of cells that changed.
  void finish();
  [[nodiscard]] const MatchGrid& grid() const { return grid_.grid(); }
  [[nodiscard]] NdtMap nds() const;
  // The valid ND of a cell, or nullptr.
  [[nodiscard]] const Nd* nd(const CellKey& key) const;
  // Whether a cell got points along 5 m of way, or along half of that of all cells where that is
  // shorter: what drives beside the vehicle fills a cell for a moment.
  [[nodiscard]] bool is_lasting(const CellKey& key) const;
  [[nodiscard]] double cell_m() const { return cell_m_; }

 private:
  struct Cell {
    CellKey key;
    CellMoments moments;
    Nd nd;
    bool is_changed = true;
    bool is_valid = false;  // the ND
    double first_m = 0.0;   // of the way
    double last_m = 0.0;
  };

  double cell_m_;
  bool has_grid_;
  double first_m_ = 0.0;  // of the way, of all points
  double last_m_ = 0.0;
  std::vector<Cell> cells_;  // by their number in the index
  CellIndex index_;
  RollingMatchGrid grid_;
};

// Moments of points by cell of both grids: computed once, then added and removed as a whole.
struct GriddedPoints {
  std::vector<CellPart> coarse, fine;
};
GriddedPoints gridded(const std::vector<Eigen::Vector3d>& points_m);

// NDs of points in cells of 2 m, with a wide basin, and of 1 m; the latter also with thin walls.
class LocalGrids {
 public:
  LocalGrids();
  [[nodiscard]] const MatchGrid& coarse() const { return coarse_.grid(); }
  [[nodiscard]] const MatchGrid& fine() const { return fine_.grid(); }
  // With walls as thin as measured, for the last centimetre. Made on first use: scans that given
  // poses lead to do not need it. Safe from several threads.
  [[nodiscard]] const MatchGrid& sharp() const;
  [[nodiscard]] const RollingCells& fine_cells() const { return fine_; }
  // The ND of 1 m of a cell, and the one that holds a point; nullptr where there is none. Valid
  // until the grids change.
  [[nodiscard]] const Nd* fine_nd(const CellKey& key) const { return fine_.nd(key); }
  [[nodiscard]] const Nd* fine_nd_at(const Eigen::Vector3d& point_map_m) const {
    return fine_.nd(cell_key(point_map_m, fine_.cell_m()));
  }

  // Sign 1 adds points, measured at `way_m` of the drive, -1 removes them; finish() is called after
  // the last change.
  void add(const GriddedPoints& points, double sign, double way_m = 0.0);
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

// Whether the vehicle has moved 1 m or 0.1 rad since the last scan of a local map, so that another
// one adds to it.
bool is_key_step(const Pose& T_map_last, const Pose& T_map_lidar);

// The latest key scans, in the map frame.
class LocalMap {
 public:
  explicit LocalMap(double reach_m) : reach_m_(reach_m) {}

  // Points of a scan in its own frame; those of scans more than the reach ago are removed.
  void add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar, double driven_m);
  // Whether a scan here is a key scan.
  [[nodiscard]] bool needs(const Pose& T_map_lidar) const {
    return is_key_step(T_map_last_, T_map_lidar);
  }
  [[nodiscard]] const LocalGrids& grids() const { return grids_; }
  // NDs of the same scans in cells of 0.5 m. Computed on request, since most places need none: not
  // safe from several threads. Valid until the map changes.
  [[nodiscard]] const RollingCells& details() const;

 private:
  struct KeyScan {
    double driven_m = 0.0;
    GriddedPoints points;
    std::vector<Eigen::Vector3d> points_map_m;
  };
  // Parts of the scans that are in the cells of 0.5 m, by the way at each.
  struct Details {
    RollingCells cells;
    std::deque<std::pair<double, std::vector<CellPart>>> parts;
  };
  double reach_m_;
  std::deque<KeyScan> scans_;
  LocalGrids grids_;
  mutable Details details_{RollingCells(kDetailCell_m, false), {}};
  Pose T_map_last_ = Pose::Identity();
};

// The points within 40 m of the sensor that belong to something upright: in a column of 0.5 m there
// are others at least 0.4 m above or below. Level points do not identify a place, since every road
// is flat. `level` turns the points so that z is up.
std::vector<Eigen::Vector3d> upright_points(const std::vector<Eigen::Vector3d>& points_m,
                                            const Eigen::Matrix3d& level);

// A place is clearly better than another one where its overlap is so much larger.
inline constexpr double kClearlyMoreOverlap = 0.08;

// Where the upright points of the latest scans are, in the map frame.
class UprightMap {
 public:
  // Points of scans more than `reach_m` of way ago are removed.
  explicit UprightMap(double reach_m) : reach_m_(reach_m) {}

  void add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar, double driven_m);

  // Share of the points that have a point of the map within 0.3 m in the plane and about 1 m in
  // height; none for fewer than 30 points.
  [[nodiscard]] std::optional<double> overlap(const std::vector<Eigen::Vector3d>& points_m,
                                              const Pose& T_map_lidar) const;

  // All points, map frame.
  [[nodiscard]] std::vector<Eigen::Vector3d> points_m() const;

 private:
  struct KeyScan {
    double driven_m = 0.0;
    std::vector<Eigen::Vector3d> points_m;
  };
  void count(const std::vector<Eigen::Vector3d>& points_m);
  [[nodiscard]] bool has_near(const Eigen::Vector3d& point_m) const;

  double reach_m_;
  std::deque<KeyScan> scans_;
  CellTable<std::int32_t> counts_;  // of points in a cell
};

}  // namespace sightline
