#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/foreign/lanes/route_parsers.h"

namespace sightline {
namespace {

using Json = nlohmann::json;

struct Reading {
  const RouteText& file;
  Route& route;
  std::size_t line_count = 0;

  [[nodiscard]] std::string place() const { return "line " + std::to_string(line_count); }
};

Result<Eigen::Vector3d> place_of(const Reading& reading, const Json& position) {
  const bool is_position = position.is_array() && position.size() >= 2 && position[0].is_number() &&
                           position[1].is_number() &&
                           (position.size() < 3 || position[2].is_number());
  if (!is_position) {
    return reading.file.error(ErrorCode::kMalformedText,
                              "expected positions of two numbers or three", reading.place());
  }
  const double height_m = position.size() > 2 ? position[2].get<double>() : kNoHeight;
  const Eigen::Vector2d at(position[0].get<double>(), position[1].get<double>());
  if (!is_place({at.x(), at.y(), height_m})) {
    return reading.file.error(ErrorCode::kMalformedText, "a place that far away is none on Earth",
                              reading.place());
  }
  if (reading.file.world.kind == WorldKind::kLocal) {
    return Eigen::Vector3d(at.x(), at.y(), height_m);
  }
  const double altitude_m = std::isnan(height_m) ? 0.0 : height_m;
  SIGHTLINE_ASSIGN(Eigen::Vector3d place_m,
                   from_geodetic(reading.file.world, {at.y(), at.x(), altitude_m}));
  if (std::isnan(height_m)) place_m.z() = kNoHeight;
  return place_m;
}

Result<void> add_line(const Json& positions, Reading& reading) {
  ++reading.line_count;
  if (!positions.is_array()) {
    return reading.file.error(ErrorCode::kMalformedText, "expected an array of positions",
                              reading.place());
  }
  std::vector<Eigen::Vector3d> points_m;
  for (const Json& position : positions) {
    SIGHTLINE_ASSIGN(const Eigen::Vector3d point_m, place_of(reading, position));
    points_m.push_back(point_m);
  }
  RouteLine line = line_of_points(reading.place(), points_m);
  if (line.points_world_m.size() > 1) reading.route.lines.push_back(std::move(line));
  return {};
}

Result<void> add_geometry(const Json& geometry, Reading& reading) {
  if (!geometry.is_object() || !geometry.contains("type")) return {};
  const bool is_line = geometry["type"] == "LineString";
  const bool are_lines = geometry["type"] == "MultiLineString";
  if (!is_line && !are_lines) return {};
  const Json& coordinates = geometry.contains("coordinates") ? geometry["coordinates"] : Json();
  if (is_line) return add_line(coordinates, reading);
  if (!coordinates.is_array()) return add_line(coordinates, reading);
  for (const Json& positions : coordinates) {
    SIGHTLINE_TRY(add_line(positions, reading));
  }
  return {};
}

// A town in degrees is smaller than a degree, and no route in metres is shorter than one.
Result<void> check_metres(const Reading& reading) {
  if (reading.file.world.kind != WorldKind::kLocal || reading.route.lines.empty()) return {};
  Eigen::AlignedBox2d box;
  for (const RouteLine& line : reading.route.lines) {
    for (const Eigen::Vector3d& point : line.points_world_m) box.extend(point.head<2>());
  }
  const bool are_degrees = box.sizes().maxCoeff() < 1.0 &&
                           box.min().cwiseAbs().maxCoeff() <= 180.0 &&
                           box.max().cwiseAbs().maxCoeff() <= 180.0;
  if (!are_degrees) return {};
  return reading.file.error(ErrorCode::kUnsupportedFormat,
                            "the lines are in degrees: say how the map lies on Earth, "
                            "route.world: utm:32N");
}

}  // namespace

Result<void> parse_geojson(const RouteText& file, Route& route) {
  // Nested deeper than any GeoJSON the parser would run out of stack.
  constexpr int kDeepest = 32;
  bool is_too_deep = false;
  const Json root = Json::parse(
      file.text,
      [&](int depth, Json::parse_event_t, Json&) {
        is_too_deep |= depth > kDeepest;
        return depth <= kDeepest;
      },
      /*allow_exceptions=*/false);
  if (root.is_discarded() || is_too_deep || !root.is_object()) {
    return file.error(ErrorCode::kMalformedText, "this is no GeoJSON");
  }
  Reading reading{file, route};
  if (root.contains("features") && root["features"].is_array()) {
    for (const Json& feature : root["features"]) {
      if (!feature.is_object() || !feature.contains("geometry")) continue;
      SIGHTLINE_TRY(add_geometry(feature["geometry"], reading));
    }
  } else {
    SIGHTLINE_TRY(add_geometry(root.contains("geometry") ? root["geometry"] : root, reading));
  }
  return check_metres(reading);
}

}  // namespace sightline
