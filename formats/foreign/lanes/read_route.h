#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/route.h"
#include "formats/geodesy.h"

namespace sightline {

// Reads the lines that a map is annotated along, in the coordinates of that map: .osm (Lanelet2:
// the centre line of each lanelet for vehicles, in its direction, in both where it is no one-way
// street), .geojson or .json (every LineString and MultiLineString), .csv (x, y and z or none, with
// a head of their names or without, or lat and lon with a head; a column `line`, or an empty line,
// sets lines apart), .tum or .txt (a trajectory; a step of more than 5 m begins another line).
// Latitudes and longitudes are put into `world`; a local one takes local_x and local_y, or
// coordinates as they are. Errors: file-not-found, cannot-read, unsupported-format (another ending;
// degrees in a local world), malformed-text with the line or element (also no place on Earth, over
// 10000 km), missing-field (no line; no lanelet for vehicles; nodes without a place), bad-argument
// (a place outside `world`), and those of read_poses.
Result<Route> read_route(const std::filesystem::path& path, const World& world);

// What the parsers of formats/foreign/lanes share; not for other folders.

// A file of lines in memory, and the world that its latitudes and longitudes are put into.
struct RouteText {
  std::string_view text;
  std::string file;
  const World& world;
  // Where a local world's local_x and local_y are counted from, in world coordinates.
  Eigen::Vector2d local_origin_world_m = Eigen::Vector2d::Zero();

  [[nodiscard]] Error error(ErrorCode code, std::string message, std::string place = "") const {
    return {code, std::move(message), file, std::move(place)};
  }
  [[nodiscard]] Error too_far(std::string place) const {
    return error(ErrorCode::kMalformedText, "a position that far away is not on Earth",
                 std::move(place));
  }
};

inline constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();

// No place on Earth is farther away from another one, or from an origin that anyone chose.
inline constexpr double kFarthest_m = 1e8;
// A longer route is none, and no machine has the memory for its sites.
inline constexpr double kLongestRoute_m = 1e7;

// Whether a place can be one: finite, and not farther than any is; its height may be NaN.
inline bool is_place(const Eigen::Vector3d& p_m) {
  const bool has_height = std::isnan(p_m.z()) || std::abs(p_m.z()) <= kFarthest_m;
  return has_height && std::abs(p_m.x()) <= kFarthest_m && std::abs(p_m.y()) <= kFarthest_m;
}

// A line of which some points may have no height (NaN): then none has. Points at one place become
// one.
inline RouteLine line_of_points(std::string name, const std::vector<Eigen::Vector3d>& points_m) {
  RouteLine line;
  line.name = std::move(name);
  line.heights = RouteHeights::kRoad;
  for (const Eigen::Vector3d& point_m : points_m) {
    if (std::isnan(point_m.z())) line.heights = RouteHeights::kNone;
  }
  for (Eigen::Vector3d point_m : points_m) {
    if (line.heights == RouteHeights::kNone) point_m.z() = 0.0;
    if (!line.points_world_m.empty() && line.points_world_m.back() == point_m) continue;
    line.points_world_m.push_back(point_m);
  }
  return line;
}

// Each appends the file's lines of two points or more.
Result<void> parse_lanelets(const RouteText& file, Route& route);
Result<void> parse_geojson(const RouteText& file, Route& route);
Result<void> parse_csv_lines(const RouteText& file, Route& route);

}  // namespace sightline
