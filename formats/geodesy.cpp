#include "formats/geodesy.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <cstdio>
#include <string>

#include "formats/text/table.h"

namespace sightline {
namespace {

// Whether a text is a number of a UTM zone (1 to 60) and a hemisphere, "32N".
bool read_zone(const std::string& text, World& world) {
  char half = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%2d%c%c", &world.utm_zone, &half, &rest) != 2) return false;
  world.kind = WorldKind::kUtm;
  world.is_north = half == 'N';
  return world.utm_zone >= 1 && world.utm_zone <= 60 && (half == 'N' || half == 'S');
}

Error bad(const std::string& found) {
  World zone;
  const std::string hint = read_zone(found, zone) ? "; write utm:" + found : "";
  return {ErrorCode::kBadArgument,
          "--world: found '" + found +
              "', expected local, utm:ZONE (utm:32N) or enu:LATITUDE,LONGITUDE,ALTITUDE" + hint,
          "", ""};
}

}  // namespace

Result<World> parse_world(std::string_view text) {
  const std::string copy(text);
  World world;
  if (copy == "local") return world;
  if (copy.starts_with("utm:")) {
    if (!read_zone(copy.substr(4), world)) return bad(copy);
    return world;
  }
  char rest = 0;
  if (std::sscanf(copy.c_str(), "enu:%lf,%lf,%lf%c", &world.latitude_deg, &world.longitude_deg,
                  &world.altitude_m, &rest) == 3) {
    const bool is_on_earth = std::abs(world.latitude_deg) <= 90.0 &&
                             std::abs(world.longitude_deg) <= 180.0 &&
                             std::isfinite(world.altitude_m);
    if (!is_on_earth) return bad(copy);
    world.kind = WorldKind::kEnu;
    return world;
  }
  return bad(copy);
}

Result<Geodetic> to_geodetic(const World& world, const Eigen::Vector3d& p_world_m) {
  Geodetic point;
  try {
    if (world.kind == WorldKind::kUtm) {
      GeographicLib::UTMUPS::Reverse(world.utm_zone, world.is_north, p_world_m.x(), p_world_m.y(),
                                     point.latitude_deg, point.longitude_deg);
      point.altitude_m = p_world_m.z();
      return point;
    }
    SIGHTLINE_CHECK(world.kind == WorldKind::kEnu);
    const GeographicLib::LocalCartesian local(world.latitude_deg, world.longitude_deg,
                                              world.altitude_m);
    local.Reverse(p_world_m.x(), p_world_m.y(), p_world_m.z(), point.latitude_deg,
                  point.longitude_deg, point.altitude_m);
    return point;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kBadArgument,
                 "--world: (" + format_double(p_world_m.x()) + ", " + format_double(p_world_m.y()) +
                     ") m is no point of that frame: " + exception.what(),
                 "", ""};
  }
}

}  // namespace sightline
