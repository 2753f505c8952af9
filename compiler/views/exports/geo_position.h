#pragma once

#include <Eigen/Core>
#include <array>

#include "formats/base/result.h"
#include "formats/geodesy.h"

namespace sightline {

// A position as GeoJSON wants it: longitude and latitude in degrees, to nine decimals, and altitude
// where the world is known, else the world coordinates, m. Error: bad-argument (no point of the
// world).
using GeoPosition = std::array<double, 3>;
Result<GeoPosition> geo_position(const World& world, const Eigen::Vector3d& p_world_m);

}  // namespace sightline
