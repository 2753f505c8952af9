#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <string_view>

#include "formats/base/result.h"

namespace sightline {

// How the world coordinates of a recording lie on Earth, which its user names once
// (annotation.world) and the map then carries.
enum class WorldKind {
  kLocal,  // nowhere: an origin and axes of its own
  kUtm,    // easting and northing of a UTM zone of WGS 84; z above the ellipsoid or the geoid
  kMgrs,   // the same from the corner of a 100 km square of MGRS, as Autoware's maps lie
  kEnu,    // east, north, up at a point of WGS 84
};

struct World {
  WorldKind kind = WorldKind::kLocal;
  int utm_zone = 0;  // 1 to 60, of UTM and MGRS
  bool is_north = true;
  // Of the world's origin in that zone: the corner of an MGRS square, else 0.
  Eigen::Vector2d corner_utm_m = Eigen::Vector2d::Zero();
  double latitude_deg = 0.0;  // of an ENU origin
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
};

// A local world as GIS programs know one: a plane of metres that lies nowhere (WKT 1).
inline constexpr const char* kLocalCrsWkt =
    "LOCAL_CS[\"the recording's own metres\",UNIT[\"metre\",1],AXIS[\"x\",EAST],AXIS[\"y\",NORTH]]";

struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
};

// "local", "utm:32N", "mgrs:32UMV", "enu:48.98,8.39,116.4" (latitude, longitude, altitude).
// Error: bad-argument.
Result<World> parse_world(std::string_view text);

// The world that a flag names ("": none), or else the one that a map or configuration carries.
// Error: bad-argument, also where both name one and they differ.
Result<World> named_world(std::string_view flag, std::string_view carried);

// Of a point in world coordinates; the world must not be local. Error: bad-argument where the point
// is none of the zone.
Result<Geodetic> to_geodetic(const World& world, const Eigen::Vector3d& p_world_m);

// The other way, to a micrometre. Error: bad-argument where the place is none of the zone.
Result<Eigen::Vector3d> from_geodetic(const World& world, const Geodetic& place);

// The axes east, north and up at a place, in world coordinates; the world must not be local. In UTM
// and MGRS they are turned to the grid's north. The same digits whichever libm there is. Error:
// bad-argument where the place is none of the zone.
Result<Eigen::Isometry3d> enu_axes(const World& world, const Geodetic& at);

// The ENU world whose origin is a place, as parse_world reads it.
std::string enu_world_name(const Geodetic& origin);

// Of a world of UTM or MGRS. EPSG's number of its zone: 32632.
int epsg_code(const World& world);
// Of the same: the square that a point lies in, "32UMV". Error: as to_geodetic.
Result<std::string> mgrs_square(const World& world, const Eigen::Vector3d& p_world_m);

}  // namespace sightline
