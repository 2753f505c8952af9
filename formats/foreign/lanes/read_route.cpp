#include "formats/foreign/lanes/read_route.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

// Which word of a row is what; nothing: there is no such column.
struct Columns {
  std::size_t x = 0, y = 1;
  std::optional<std::size_t> z;
  std::optional<std::size_t> line;
  std::size_t count = 0;     // 0: not known yet
  bool are_degrees = false;  // x is the longitude, y the latitude
};

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, word) != names.end();
}

// The world whose UTM zone holds a place: "utm:32N".
std::string utm_zone_of(double longitude_deg, double latitude_deg) {
  const int zone = static_cast<int>(std::floor((longitude_deg + 180.0) / 6.0)) % 60 + 1;
  return concat("utm:", zone, latitude_deg < 0.0 ? "S" : "N");
}

// A row of names. Error: missing-field.
Result<Columns> columns_of_head(const RouteText& file, const std::vector<std::string_view>& words) {
  Columns columns;
  columns.count = words.size();
  std::optional<std::size_t> x, y;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool is_longitude = is_one_of(words[i], {"lon", "lng", "longitude", "longitude_deg"});
    const bool is_latitude = is_one_of(words[i], {"lat", "latitude", "latitude_deg"});
    columns.are_degrees |= is_longitude;
    if (is_longitude || is_one_of(words[i], {"x", "x_m"})) x = i;
    if (is_latitude || is_one_of(words[i], {"y", "y_m"})) y = i;
    if (words[i] == "z" || words[i] == "z_m") columns.z = i;
    if (words[i] == "line" || words[i] == "lane") columns.line = i;
  }
  if (!x || !y) {
    return file.error(ErrorCode::kMissingField,
                      "expected columns x and y, or lat and lon, and optionally z", "line 1");
  }
  columns.x = *x;
  columns.y = *y;
  return columns;
}

// Rows of numbers alone: x y, or x y z.
Result<Columns> columns_of_numbers(const RouteText& file, std::size_t count,
                                   const std::string& place) {
  if (count != 2 && count != 3) {
    return file.error(
        ErrorCode::kMalformedText,
        concat("found ", count,
               " columns and no line that names them, expected x, y and optionally z"),
        place);
  }
  Columns columns;
  columns.count = count;
  if (count == 3) columns.z = 2;
  return columns;
}

// A longitude, a latitude and a height or none, in the world of the map.
Result<Eigen::Vector3d> from_degrees(const RouteText& file, const Eigen::Vector3d& at,
                                     const std::string& place) {
  if (file.world.kind == WorldKind::kLocal) {
    return file.error(ErrorCode::kUnsupportedFormat,
                      concat("the route is in degrees. Name the coordinate system of the map: "
                             "route.world: ",
                             utm_zone_of(at.x(), at.y())),
                      place);
  }
  const double altitude_m = std::isnan(at.z()) ? 0.0 : at.z();
  SIGHTLINE_ASSIGN(Eigen::Vector3d place_m,
                   from_geodetic(file.world, {at.y(), at.x(), altitude_m}));
  if (std::isnan(at.z())) place_m.z() = kNoHeight;
  return place_m;
}

Result<Eigen::Vector3d> point_of(const RouteText& file, const Columns& columns,
                                 const std::vector<std::string_view>& words,
                                 const std::string& place) {
  if (words.size() != columns.count) {
    return file.error(ErrorCode::kMalformedText,
                      concat("found ", words.size(), " columns, expected ", columns.count), place);
  }
  const std::array<std::optional<std::size_t>, 3> of_axis = {columns.x, columns.y, columns.z};
  Eigen::Vector3d point_m(0.0, 0.0, kNoHeight);
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<std::size_t> column = of_axis[static_cast<std::size_t>(axis)];
    if (!column) continue;
    const std::optional<double> number = finite_number(words[*column]);
    if (!number) {
      return file.error(ErrorCode::kMalformedText,
                        concat("found ", in_quotes(words[*column]), ", expected a number"), place);
    }
    point_m[axis] = *number;
  }
  if (!is_place(point_m)) return file.too_far(place);
  if (!columns.are_degrees) return point_m;
  return from_degrees(file, point_m, place);
}

// Lines as they come: points are gathered until the next one begins.
class LineGatherer {
 public:
  explicit LineGatherer(Route& route) : route_(route) {}
  void add(std::string_view key, const Eigen::Vector3d& point_m) {
    if (key != key_) end();
    key_ = key;
    points_m_.push_back(point_m);
  }
  void end() {
    RouteLine line = line_of_points(concat("line ", ++count_), points_m_);
    if (line.points_world_m.size() > 1) route_.lines.push_back(std::move(line));
    if (points_m_.empty()) --count_;
    points_m_.clear();
  }

 private:
  Route& route_;
  std::string key_;
  std::vector<Eigen::Vector3d> points_m_;
  std::size_t count_ = 0;
};

using Json = nlohmann::json;

struct Reading {
  const RouteText& file;
  Route& route;
  std::size_t line_count = 0;

  [[nodiscard]] std::string place() const { return concat("line ", line_count); }
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
  if (!is_place({at.x(), at.y(), height_m})) return reading.file.too_far(reading.place());
  if (reading.file.world.kind == WorldKind::kLocal) {
    return Eigen::Vector3d(at.x(), at.y(), height_m);
  }
  return from_degrees(reading.file, {at.x(), at.y(), height_m}, reading.place());
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
  if (is_line || !coordinates.is_array()) return add_line(coordinates, reading);
  for (const Json& positions : coordinates) SIGHTLINE_TRY(add_line(positions, reading));
  return {};
}

// A town in degrees is smaller than a degree, and no route in metres is shorter than one.
Result<void> check_metres(const RouteText& file, const Route& route, std::string_view first_step) {
  if (route.lines.empty()) return {};
  Eigen::AlignedBox2d box;
  for (const RouteLine& line : route.lines) {
    for (const Eigen::Vector3d& point : line.points_world_m) box.extend(point.head<2>());
  }
  const bool are_degrees = box.sizes().maxCoeff() < 1.0 &&
                           box.min().cwiseAbs().maxCoeff() <= 180.0 &&
                           box.max().cwiseAbs().maxCoeff() <= 180.0;
  if (!are_degrees) return {};
  return file.error(ErrorCode::kUnsupportedFormat,
                    concat("the lines are in degrees. ", first_step,
                           "Name the coordinate system of the map, for example route.world: ",
                           utm_zone_of(box.center().x(), box.center().y())));
}

// As choose-sites does with the poses of a drive.
constexpr double kSmallestStep_m = 0.1;
constexpr double kLargestGap_m = 5.0;

Result<void> read_trajectory(const std::filesystem::path& path, Route& route) {
  SIGHTLINE_ASSIGN(const std::vector<PoseRow> rows, read_poses(path, PoseFormat::kTum));
  std::vector<RouteLine> lines;
  for (const PoseRow& row : rows) {
    const Eigen::Vector3d place_m = row.T_world_vehicle.translation();
    const bool is_first = lines.empty();
    const double step_m = is_first ? 0.0 : (place_m - lines.back().points_world_m.back()).norm();
    if (!is_first && step_m < kSmallestStep_m) continue;
    if (is_first || step_m > kLargestGap_m) {
      lines.emplace_back();
      lines.back().name = concat("line ", lines.size());
      lines.back().heights = RouteHeights::kVehicle;
    }
    lines.back().points_world_m.push_back(place_m);
  }
  for (RouteLine& line : lines) {
    if (line.points_world_m.size() > 1) route.lines.push_back(std::move(line));
  }
  return {};
}

Result<void> read_lines(const std::filesystem::path& path, const World& world, Route& route) {
  const std::string extension = lower_extension(path);
  if (extension == ".tum" || extension == ".txt") return read_trajectory(path, route);
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(path));
  const RouteText file{text, path.string(), world};
  if (extension == ".osm") return parse_lanelets(file, route);
  if (extension == ".geojson" || extension == ".json") return parse_geojson(file, route);
  if (extension == ".csv") return parse_csv_lines(file, route);
  return file.error(ErrorCode::kUnsupportedFormat,
                    "a route is .osm (Lanelet2), .geojson, .csv, or a trajectory .tum or .txt");
}

double length_m(const Route& route) {
  double sum_m = 0.0;
  for (const RouteLine& line : route.lines) {
    for (std::size_t i = 1; i < line.points_world_m.size(); ++i) {
      sum_m += (line.points_world_m[i] - line.points_world_m[i - 1]).head<2>().norm();
    }
  }
  return sum_m;
}

}  // namespace

Result<void> parse_csv_lines(const RouteText& file, Route& route) {
  constexpr std::string_view kSeparators = ",; \t\"";
  Columns columns;
  LineGatherer gatherer(route);
  LineReader lines(file.text);
  std::vector<std::string_view> words;
  for (std::string_view text; lines.next(text);) {
    const std::string place = concat("line ", lines.number());
    if (text.starts_with('#')) continue;
    split_words(text, words, kSeparators);
    if (words.empty()) {
      gatherer.end();
      continue;
    }
    if (columns.count == 0) {
      const bool is_head = !to_number<double>(words.front());
      SIGHTLINE_ASSIGN(columns, is_head ? columns_of_head(file, words)
                                        : columns_of_numbers(file, words.size(), place));
      if (is_head) continue;
    }
    SIGHTLINE_ASSIGN(const Eigen::Vector3d point_m, point_of(file, columns, words, place));
    gatherer.add(columns.line ? words[*columns.line] : std::string_view(), point_m);
  }
  gatherer.end();
  if (columns.are_degrees) return {};
  return check_metres(file, route, "Name the columns in the first line (lat,lon). ");
}

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
    return file.error(ErrorCode::kMalformedText, "the file is not valid GeoJSON");
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
  return file.world.kind == WorldKind::kLocal ? check_metres(file, route, "") : Result<void>();
}

Result<Route> read_route(const std::filesystem::path& path, const World& world) {
  Route route;
  route.name = path.filename().string();
  SIGHTLINE_TRY(read_lines(path, world, route));
  if (!(length_m(route) <= kLongestRoute_m)) {
    return Error{ErrorCode::kMalformedText,
                 "its lines are longer than 10000 km: are they in metres?", path.string()};
  }
  if (!route.lines.empty()) return route;
  return Error{ErrorCode::kMissingField, "found no line of two points or more", path.string()};
}

}  // namespace sightline
