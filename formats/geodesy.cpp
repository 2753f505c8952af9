#include "formats/geodesy.h"

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/MGRS.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "formats/geometry.h"
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

// What was probably meant: a bare zone, or a code of EPSG, of which 32601 to 32660 are UTM north
// and 32701 to 32760 south, on WGS 84.
std::string hint_of(const std::string& found) {
  World zone;
  if (read_zone(found, zone)) return "; write utm:" + found;
  int code = 0;
  char rest = 0;
  if (std::sscanf(found.c_str(), "%*[EePpSsGg]:%d%c", &code, &rest) != 1) return "";
  const int number = code % 100;
  const bool is_utm = (code / 100 == 326 || code / 100 == 327) && number >= 1 && number <= 60;
  if (!is_utm)
    return "; of EPSG codes, only those of UTM on WGS 84 (32601 to 32760) have a form here";
  return concat("; write utm:", number, code / 100 == 326 ? "N" : "S");
}

Error bad(const std::string& found) {
  return {ErrorCode::kBadArgument,
          concat("world: found '", found,
                 "', expected local, utm:ZONE (utm:32N), mgrs:SQUARE (mgrs:32UMV) or "
                 "enu:LATITUDE,LONGITUDE,ALTITUDE",
                 hint_of(found))};
}

// Whether a text names a square of 100 km, "32UMV"; not one of the poles, which have no zone.
bool read_square(const std::string& text, World& world) {
  int digits = -1;
  try {
    GeographicLib::MGRS::Reverse(text, world.utm_zone, world.is_north, world.corner_utm_m.x(),
                                 world.corner_utm_m.y(), digits, /*centerp=*/false);
  } catch (const std::exception&) {
    return false;
  }
  world.kind = WorldKind::kMgrs;
  return digits == 0 && world.utm_zone >= 1;
}

bool is_of_zone(const World& world) {
  return world.kind == WorldKind::kUtm || world.kind == WorldKind::kMgrs;
}

Error no_point(const Eigen::Vector3d& p_world_m, const std::exception& reason) {
  return {ErrorCode::kBadArgument,
          concat("world: (", format_double(p_world_m.x()), ", ", format_double(p_world_m.y()),
                 ") m is not a point of that frame: ", reason.what())};
}

}  // namespace

Result<World> parse_world(std::string_view text) {
  const std::string copy(text);
  World world;
  if (copy == "local") return world;
  if (copy.starts_with("utm:") && read_zone(copy.substr(4), world)) return world;
  if (copy.starts_with("mgrs:") && read_square(copy.substr(5), world)) return world;
  char rest = 0;
  if (std::sscanf(copy.c_str(), "enu:%lf,%lf,%lf%c", &world.latitude_deg, &world.longitude_deg,
                  &world.altitude_m, &rest) == 3) {
    const bool is_on_earth = std::abs(world.latitude_deg) <= 90.0 &&
                             std::abs(world.longitude_deg) <= 180.0 &&
                             std::isfinite(world.altitude_m);
    world.kind = WorldKind::kEnu;
    if (is_on_earth) return world;
  }
  return bad(copy);
}

Result<World> named_world(std::string_view flag, std::string_view carried) {
  SIGHTLINE_ASSIGN(const World own, parse_world(carried));
  if (flag.empty() || flag == carried) return own;
  SIGHTLINE_ASSIGN(const World named, parse_world(flag));
  if (own.kind == WorldKind::kLocal) return named;
  return Error{
      ErrorCode::kBadArgument,
      concat("--world ", flag, ": the map contains its own world, ", carried, "; remove the flag")};
}

Result<Geodetic> to_geodetic(const World& world, const Eigen::Vector3d& p_world_m) {
  Geodetic point;
  try {
    if (is_of_zone(world)) {
      const Eigen::Vector2d utm_m = p_world_m.head<2>() + world.corner_utm_m;
      GeographicLib::UTMUPS::Reverse(world.utm_zone, world.is_north, utm_m.x(), utm_m.y(),
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
    return no_point(p_world_m, exception);
  }
}

Result<Eigen::Isometry3d> enu_axes(const World& world, const Geodetic& at) {
  Eigen::Isometry3d axes = Eigen::Isometry3d::Identity();
  Eigen::Vector3d place_m(0.0, 0.0, at.altitude_m);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  try {
    if (is_of_zone(world)) {
      int zone = 0;
      bool is_north = true;
      double convergence_deg = 0.0;
      double scale = 1.0;
      GeographicLib::UTMUPS::Forward(at.latitude_deg, at.longitude_deg, zone, is_north, place_m.x(),
                                     place_m.y(), convergence_deg, scale, world.utm_zone);
      const double shift_m = GeographicLib::UTMUPS::UTMShift();  // south of the equator
      if (is_north && !world.is_north) place_m.y() += shift_m;
      if (!is_north && world.is_north) place_m.y() -= shift_m;
      place_m.head<2>() -= world.corner_utm_m;
      const double angle_rad = convergence_deg * std::numbers::pi / 180.0;
      turn = rotation_matrix({Eigen::Vector3d::UnitZ(), angle_rad});
    } else {
      SIGHTLINE_CHECK(world.kind == WorldKind::kEnu);
      const GeographicLib::LocalCartesian local(world.latitude_deg, world.longitude_deg,
                                                world.altitude_m);
      std::vector<double> matrix(9);
      local.Forward(at.latitude_deg, at.longitude_deg, at.altitude_m, place_m.x(), place_m.y(),
                    place_m.z(), matrix);
      turn = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.data());
    }
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kBadArgument,
                 concat("world: latitude ", format_double(at.latitude_deg), ", longitude ",
                        format_double(at.longitude_deg), " is not in it: ", exception.what())};
  }
  if (!place_m.allFinite() || !turn.allFinite()) {
    return Error{ErrorCode::kBadArgument, "world: the position is not finite"};
  }
  // Libraries of mathematics differ in the last digits; a map's bytes must not.
  axes.translation() = (place_m * 1e6).array().round() / 1e6;
  axes.linear() = (turn * 1e12).array().round() / 1e12;
  return axes;
}

std::string enu_world_name(const Geodetic& origin) {
  return concat("enu:", format_double(origin.latitude_deg), ",",
                format_double(origin.longitude_deg), ",", format_double(origin.altitude_m));
}

int epsg_code(const World& world) {
  SIGHTLINE_CHECK(is_of_zone(world));
  return (world.is_north ? 32600 : 32700) + world.utm_zone;
}

Result<std::string> mgrs_square(const World& world, const Eigen::Vector3d& p_world_m) {
  SIGHTLINE_CHECK(is_of_zone(world));
  const Eigen::Vector2d utm_m = p_world_m.head<2>() + world.corner_utm_m;
  try {
    std::string square;
    GeographicLib::MGRS::Forward(world.utm_zone, world.is_north, utm_m.x(), utm_m.y(), 0, square);
    return square;
  } catch (const std::exception& exception) {
    return no_point(p_world_m, exception);
  }
}

Result<Eigen::Vector3d> from_geodetic(const World& world, const Geodetic& place) {
  SIGHTLINE_ASSIGN(const Eigen::Isometry3d axes, enu_axes(world, place));
  return Eigen::Vector3d(axes.translation());
}

}  // namespace sightline
