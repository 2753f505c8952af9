#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/geometry.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/trajectory/local/wider_starts.h"

namespace sightline {

// Where in a map a vehicle may be whose pose is not known ("Global localization" in
// schemas/definitions.md): the roads of the map are searched at every heading for upright surfaces
// and lines that lie as the scan's upright points do.
class PlaceFinder {
 public:
  // `route_world_m`: positions of the sensor along the roads of the map.
  PlaceFinder(const NdtMap& map, std::span<const Eigen::Vector3d> route_world_m,
              const Pose& T_vehicle_sensor);

  // Poses of the vehicle, level, the likeliest first; none where no place is likely. `upright_m`:
  // of the scan (upright_of), in the vehicle's frame. Poses are right to about 0.5 m and 1 degree;
  // those within 1.5 m and 10 degrees of a likelier one are left out. The same for any number of
  // threads.
  [[nodiscard]] std::vector<Pose> likely_places(const std::vector<Eigen::Vector3d>& upright_m,
                                                int threads) const;

 private:
  using Block = std::pair<int, int>;  // a square of the plane

  [[nodiscard]] std::vector<Eigen::Vector3d> map_points_around(const Eigen::Vector3d& at_m) const;
  // Of some stretches of the route from `first` on.
  [[nodiscard]] std::vector<WiderStart> starts_of(const std::vector<Eigen::Vector3d>& upright_m,
                                                  const WideSearch& search, std::size_t first,
                                                  int threads) const;

  MapFrame frame_;
  std::vector<Eigen::Vector3d> middles_m_;  // of stretches of the route, where a vehicle stands
  std::map<Block, std::vector<Eigen::Vector3d>> upright_m_;  // of the map, by block
};

}  // namespace sightline
