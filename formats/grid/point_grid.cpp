#include "formats/grid/point_grid.h"

#include <cmath>
#include <tuple>

#include "formats/base/check.h"

namespace sightline {
namespace {

// A coordinate beyond belongs to the outermost cell: keys still ascend with coordinates, which is
// all that a search needs of them.
std::int32_t key_along(double coordinate_m, double cell_m) {
  constexpr double kFarthest = 0x1.0p30;
  return static_cast<std::int32_t>(
      std::clamp(std::floor(coordinate_m / cell_m), -kFarthest, kFarthest));
}

}  // namespace

PointGrid::PointGrid(std::span<const Eigen::Vector3d> points_m, double cell_m) : cell_m_(cell_m) {
  SIGHTLINE_CHECK(cell_m > 0.0);
  entries_.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!points_m[i].allFinite()) continue;
    entries_.push_back({cell_of(points_m[i].head<2>()), i, points_m[i]});
    box_m_.extend(points_m[i]);
  }
  std::ranges::sort(entries_, [](const Entry& a, const Entry& b) {
    return std::tie(a.cell, a.index) < std::tie(b.cell, b.index);
  });
}

TileKey PointGrid::cell_of(const Eigen::Vector2d& p_m) const {
  return {key_along(p_m.x(), cell_m_), key_along(p_m.y(), cell_m_)};
}

PointGrid::Place PointGrid::first_from(Place begin, const TileKey& cell) const {
  return std::lower_bound(begin, entries_.end(), cell,
                          [](const Entry& entry, const TileKey& key) { return entry.cell < key; });
}

double PointGrid::farthest_m(const Eigen::Vector3d& p_m) const {
  const Eigen::Vector3d away_m =
      (p_m - box_m_.min()).cwiseAbs().cwiseMax((p_m - box_m_.max()).cwiseAbs());
  return away_m.norm() * (1.0 + 1e-12);  // so that rounding leaves out no point
}

std::optional<NearPoint> PointGrid::nearest(const Eigen::Vector3d& p_m, double reach_m) const {
  return nearest(p_m, reach_m, [](const NearPoint&) { return true; });
}

std::optional<NearPoint> PointGrid::nearest_on_level(const Eigen::Vector3d& p_m,
                                                     double reach_m) const {
  return nearest_of(p_m, reach_m, [&](const NearPoint& /*point*/, const Eigen::Vector3d& point_m) {
    return is_same_level(p_m.z(), point_m.z());
  });
}

std::vector<NearPoint> PointGrid::within(const Eigen::Vector3d& p_m, double reach_m) const {
  std::vector<NearPoint> found;
  visit_within(p_m, reach_m, [&](const NearPoint& point) { found.push_back(point); });
  std::ranges::sort(found);
  return found;
}

}  // namespace sightline
