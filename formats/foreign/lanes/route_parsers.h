#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/route.h"
#include "formats/geodesy.h"

// What the parsers of formats/foreign/lanes share; not for other folders.

namespace sightline {

// A file of lines in memory, and the world that its latitudes and longitudes are put into.
struct RouteText {
  std::string_view text;
  std::string file;
  const World& world;

  [[nodiscard]] Error error(ErrorCode code, std::string message, std::string place = "") const {
    return {code, std::move(message), file, std::move(place)};
  }
};

inline constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();

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
