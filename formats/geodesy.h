#pragma once

#include <Eigen/Core>
#include <string_view>

#include "formats/base/result.h"

// Where on the Earth a recording's coordinates lie.

namespace sightline {

// How the world coordinates of a recording lie on Earth, which no map knows and its user names.
enum class WorldKind {
  kLocal,  // nowhere: an origin and axes of its own
  kUtm,    // easting and northing of a UTM zone of WGS 84; z above the ellipsoid or the geoid
  kEnu,    // east, north, up at a point of WGS 84
};

struct World {
  WorldKind kind = WorldKind::kLocal;
  int utm_zone = 0;  // 1 to 60
  bool is_north = true;
  double latitude_deg = 0.0;  // of an ENU origin
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
};

struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
};

// "local", "utm:32N", "enu:48.98,8.39,116.4" (latitude, longitude, altitude). Error: bad-argument.
Result<World> parse_world(std::string_view text);

// Of a point in world coordinates; the world must not be local. Error: bad-argument where the point
// is none of the zone.
Result<Geodetic> to_geodetic(const World& world, const Eigen::Vector3d& p_world_m);

}  // namespace sightline
