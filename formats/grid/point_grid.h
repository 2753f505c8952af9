#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <compare>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/level.h"
#include "formats/grid/cell_key.h"

namespace sightline {

// A point of a grid, and how far it is from the place that was asked about. The nearer comes first,
// of two equally near the one of the lower index.
struct NearPoint {
  double distance_m = 0.0;
  std::size_t index = 0;
  friend auto operator<=>(const NearPoint&, const NearPoint&) = default;
};

// Finds the points near a place: sites of a route, scans of a drive. A question costs what lies
// near the place, however many points there are and however far away the place is.
//
// Answers are those of asking every point for its distance (a - b).norm(), to the bit, whatever the
// cell's edge. Distances are in space: with z = 0 everywhere they are in the plane. A point with a
// coordinate that is not finite is never found, and nothing is near a place that is not finite.
class PointGrid {
 public:
  // Sites lie metres apart and are asked for within metres.
  static constexpr double kCell_m = 4.0;

  // Of no points.
  PointGrid() = default;
  // Any number of points, several of them at one place or none. `cell_m` > 0: the edge of the
  // square cells that points are sorted into, as wide as what is asked for most.
  explicit PointGrid(std::span<const Eigen::Vector3d> points_m, double cell_m = kCell_m);

  // The points of it that are finite.
  [[nodiscard]] std::size_t size() const { return entries_.size(); }

  // The nearest point at most reach_m away (infinity: anywhere) that accept(NearPoint) is true of.
  template <class Accept>
  [[nodiscard]] std::optional<NearPoint> nearest(const Eigen::Vector3d& p_m, double reach_m,
                                                 const Accept& accept) const;
  [[nodiscard]] std::optional<NearPoint> nearest(const Eigen::Vector3d& p_m, double reach_m) const;

  // The nearest point at most reach_m away on the same level (is_same_level): of sensors' places.
  [[nodiscard]] std::optional<NearPoint> nearest_on_level(const Eigen::Vector3d& p_m,
                                                          double reach_m) const;

  // All points at most reach_m away, the nearest first.
  [[nodiscard]] std::vector<NearPoint> within(const Eigen::Vector3d& p_m, double reach_m) const;

  // Calls use(NearPoint) for each point at most reach_m away, in no promised order.
  template <class Use>
  void visit_within(const Eigen::Vector3d& p_m, double reach_m, const Use& use) const;

  // Calls use(index) for each point over the box, faces included, in no promised order.
  template <class Use>
  void visit_over(const Eigen::AlignedBox2d& box_m, const Use& use) const;

 private:
  struct Entry {
    TileKey cell;
    std::size_t index = 0;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  };
  using Place = std::vector<Entry>::const_iterator;

  [[nodiscard]] TileKey cell_of(const Eigen::Vector2d& p_m) const;
  // The first entry of this cell or a later one.
  [[nodiscard]] Place first_from(Place begin, const TileKey& cell) const;
  // Distance to the corner of all points that is farthest away.
  [[nodiscard]] double farthest_m(const Eigen::Vector3d& p_m) const;
  template <class Use>
  void visit_cells(const TileKey& low, const TileKey& high, const Use& use) const;
  // Calls use(NearPoint, point) for each point at most reach_m away.
  template <class Use>
  void visit_near(const Eigen::Vector3d& p_m, double reach_m, const Use& use) const;
  // The nearest point at most reach_m away that accept(NearPoint, point) is true of.
  template <class Accept>
  [[nodiscard]] std::optional<NearPoint> nearest_of(const Eigen::Vector3d& p_m, double reach_m,
                                                    const Accept& accept) const;

  double cell_m_ = kCell_m;
  std::vector<Entry> entries_;  // ascending by (cell, index)
  Eigen::AlignedBox3d box_m_;   // of all of them
};

// Columns of cells that hold nothing cost nothing, so no box is too large.
template <class Use>
void PointGrid::visit_cells(const TileKey& low, const TileKey& high, const Use& use) const {
  Place entry = first_from(entries_.begin(), low);
  while (entry != entries_.end() && entry->cell.x <= high.x) {
    if (entry->cell.y < low.y) {
      entry = first_from(entry, {entry->cell.x, low.y});
    } else if (entry->cell.y > high.y) {
      entry = first_from(entry, {entry->cell.x + 1, low.y});
    } else {
      use(*entry++);
    }
  }
}

template <class Use>
void PointGrid::visit_near(const Eigen::Vector3d& p_m, double reach_m, const Use& use) const {
  if (!p_m.allFinite() || !(reach_m >= 0.0)) return;
  // Wider by more than rounding makes of a distance, squares that vanish included.
  const Eigen::Vector2d wide_m = Eigen::Vector2d::Constant(reach_m * (1.0 + 1e-12) + 1e-150);
  const Eigen::Vector2d middle_m = p_m.head<2>();
  visit_cells(cell_of(middle_m - wide_m), cell_of(middle_m + wide_m), [&](const Entry& entry) {
    const double distance_m = (entry.point_m - p_m).norm();
    if (distance_m <= reach_m) use(NearPoint{distance_m, entry.index}, entry.point_m);
  });
}

template <class Use>
void PointGrid::visit_within(const Eigen::Vector3d& p_m, double reach_m, const Use& use) const {
  visit_near(p_m, reach_m,
             [&](const NearPoint& point, const Eigen::Vector3d& /*point_m*/) { use(point); });
}

template <class Use>
void PointGrid::visit_over(const Eigen::AlignedBox2d& box_m, const Use& use) const {
  if (!(box_m.min().array() <= box_m.max().array()).all()) return;
  visit_cells(cell_of(box_m.min()), cell_of(box_m.max()), [&](const Entry& entry) {
    if (box_m.contains(entry.point_m.head<2>())) use(entry.index);
  });
}

template <class Accept>
std::optional<NearPoint> PointGrid::nearest(const Eigen::Vector3d& p_m, double reach_m,
                                            const Accept& accept) const {
  return nearest_of(p_m, reach_m, [&](const NearPoint& point, const Eigen::Vector3d& /*point_m*/) {
    return accept(point);
  });
}

template <class Accept>
std::optional<NearPoint> PointGrid::nearest_of(const Eigen::Vector3d& p_m, double reach_m,
                                               const Accept& accept) const {
  if (entries_.empty() || !p_m.allFinite() || !(reach_m >= 0.0)) return std::nullopt;
  // What lies within a cell's edge mostly decides; else twice as far is looked, and so on. Nothing
  // farther away than the first point found can be nearer.
  const double most_m = std::min(reach_m, farthest_m(p_m));
  double radius_m = std::min(cell_m_, most_m);
  while (true) {
    std::optional<NearPoint> best;
    visit_near(p_m, radius_m, [&](const NearPoint& point, const Eigen::Vector3d& point_m) {
      if ((!best || point < *best) && accept(point, point_m)) best = point;
    });
    if (best || !(radius_m < most_m)) return best;
    radius_m = std::min(2.0 * radius_m, most_m);
  }
}

}  // namespace sightline
