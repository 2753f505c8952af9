#include "compiler/views/exports/geo_position.h"

#include <cmath>

namespace sightline {
namespace {

// Nine decimals of a degree are a tenth of a millimetre.
double rounded_deg(double value) { return std::round(value * 1e9) / 1e9; }

}  // namespace

Result<GeoPosition> geo_position(const World& world, const Eigen::Vector3d& p_world_m) {
  if (world.kind == WorldKind::kLocal) {
    return GeoPosition{p_world_m.x(), p_world_m.y(), p_world_m.z()};
  }
  SIGHTLINE_ASSIGN(const Geodetic point, to_geodetic(world, p_world_m));
  return GeoPosition{rounded_deg(point.longitude_deg), rounded_deg(point.latitude_deg),
                     point.altitude_m};
}

}  // namespace sightline
