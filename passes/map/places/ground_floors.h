#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// The heights at which a vehicle could stand over places of the plane, from the level patches of a
// surface. Of a surface with cells wider than a column a patch counts in each column that the
// middle of a solid square of it lies in.
class GroundFloors {
 public:
  static constexpr double kColumn_m = 1.0;  // edge of the columns that patches are sorted into

  GroundFloors() = default;  // of nothing
  explicit GroundFloors(const Surface& surface) { add(surface); }
  // What lies in further tiles, after those before them in the surface's order.
  void add(const Surface& tile);

  // Heights over a place of the map, ascending. The lowest level that more than a third of the
  // square of 3 m around it has; each further one at least 2.5 m above the one below, where level
  // patches lie over at least half of that square: a bridge, a roof, another storey. Empty where
  // no ground was seen.
  [[nodiscard]] std::vector<double> at(const Eigen::Vector2d& place_map_m) const;

  // True where level ground of about that height was seen in the column of a place, not only
  // extrapolated from ground beside it (ground_gaps.h).
  [[nodiscard]] bool is_seen(const Eigen::Vector2d& place_map_m, double height_m) const;
  // Whether that holds in the square of 3 m around the place, by the planes known at it.
  [[nodiscard]] bool is_seen_around(const Eigen::Vector2d& place_map_m, double height_m) const;

  // Columns that have a level patch, in no promised order, each once. Elsewhere there is a floor
  // within a column of them at most.
  [[nodiscard]] std::span<const CellKey> columns() const { return columns_.keys(); }

 private:
  struct Level {
    double height_m = 0.0;
    Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
    double slope_x = 0.0, slope_y = 0.0;  // of the patch's plane
    bool is_seen = true;

    [[nodiscard]] double height_at_m(const Eigen::Vector2d& place_map_m) const {
      const Eigen::Vector2d off_m = place_map_m - place_m;
      return height_m + slope_x * off_m.x() + slope_y * off_m.y();
    }
  };
  // Calls use(level, number of its column) for the levels in the square of 3 m around a place.
  template <class Use>
  void visit_around(const Eigen::Vector2d& place_map_m, const Use& use) const;
  CellTable<std::vector<Level>> columns_;  // keys with z = 0
};

// Of a whole surface, of which one tile at a time is in memory. Error: cannot-read.
Result<GroundFloors> floors_of(const TiledSurface& surface);

// A place without a drive, as a site.

// Height of the vehicle's origin where it stands on the ground.
inline double vehicle_above_ground_m(const SensorProfile& sensor) {
  return sensor.height_m - sensor.T_vehicle_lidar.translation().z();
}

// The vehicle's origin is at vehicle_map_m, it stands level and looks along `heading` (of unit
// length, in the plane).
inline Site level_site(std::uint32_t run, double s_m, const Eigen::Vector3d& vehicle_map_m,
                       const Eigen::Vector2d& heading, const SensorProfile& sensor) {
  Site site;
  site.run = run;
  site.s_m = s_m;
  site.T_map_vehicle.linear().col(0) << heading.x(), heading.y(), 0.0;
  site.T_map_vehicle.linear().col(1) << -heading.y(), heading.x(), 0.0;
  site.T_map_vehicle.translation() = vehicle_map_m;
  site.p_map_m = (site.T_map_vehicle * sensor.T_vehicle_lidar).translation();
  return site;
}

}  // namespace sightline
