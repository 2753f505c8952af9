#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "formats/geometry.h"
#include "formats/grid/cell_index.h"

// How much of a scan is found in a local map; part of estimate-trajectory. Level returns do not
// identify a place, since every road is flat: only upright things count.

namespace sightline {

// The points within 40 m of the sensor that belong to something upright: in a column of 0.5 m there
// are others at least 0.4 m above or below. `level` turns the points so that z is up.
std::vector<Eigen::Vector3d> upright_points(const std::vector<Eigen::Vector3d>& points_m,
                                            const Eigen::Matrix3d& level);

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
