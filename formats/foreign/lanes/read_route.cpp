#include "formats/foreign/lanes/read_route.h"

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/lanes/route_parsers.h"
#include "formats/foreign/text/lower_extension.h"
#include "formats/foreign/text/pose_file.h"

namespace sightline {
namespace {

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
      lines.back().name = "line " + std::to_string(lines.size());
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
