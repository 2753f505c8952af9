#include "compiler/views/exports/autoware.h"

#include <cmath>
#include <map>

#include "formats/text/table.h"

namespace sightline {
namespace {

// What is added to map coordinates.
Eigen::Vector3d shift_m(const MapFrame& frame, const World& world) {
  if (world.kind == WorldKind::kEnu) return frame.origin_world_m;
  return {0.0, 0.0, frame.origin_world_m.z()};
}

int corner_m(float coordinate_m) {
  // Of the number as it is written: rounding to float may not move a point out of its square.
  return static_cast<int>(kAutowareSquare_m) *
         static_cast<int>(std::floor(static_cast<double>(coordinate_m) / kAutowareSquare_m));
}

std::string metadata_of(const std::vector<AutowareSquare>& squares) {
  const std::string edge = "20.0";
  std::string yaml = "x_resolution: " + edge + "\ny_resolution: " + edge + "\n";
  for (const AutowareSquare& square : squares) {
    yaml += square.file + ": [" + std::to_string(square.x_m) + ", " + std::to_string(square.y_m) +
            "]\n";
  }
  return yaml;
}

std::string origin_yaml(const Geodetic& origin) {
  return "vertical_datum: WGS84\nmap_origin:\n  latitude: " + format_double(origin.latitude_deg) +
         "\n  longitude: " + format_double(origin.longitude_deg) + "\n  altitude: 0.0\n";
}

Result<std::string> projector_of(const MapFrame& frame, const World& world) {
  if (world.kind == WorldKind::kLocal) {
    return "# x and y are the recording's world minus (" + format_double(frame.origin_world_m.x()) +
           ", " + format_double(frame.origin_world_m.y()) + ") m\nprojector_type: Local\n";
  }
  if (world.kind == WorldKind::kEnu) {
    return "projector_type: LocalCartesian\n" +
           origin_yaml({world.latitude_deg, world.longitude_deg, 0.0});
  }
  SIGHTLINE_ASSIGN(const Geodetic origin, to_geodetic(world, frame.origin_world_m));
  return "projector_type: LocalCartesianUTM\n" + origin_yaml(origin);
}

}  // namespace

Result<AutowareMap> autoware_map(const std::vector<Eigen::Vector3d>& points_map_m,
                                 const MapFrame& frame, const World& world) {
  if (points_map_m.empty()) return Error{ErrorCode::kEmptyMap, "there are no points", "", ""};
  SIGHTLINE_ASSIGN(std::string projector, projector_of(frame, world));
  const Eigen::Vector3d shift = shift_m(frame, world);
  std::map<std::pair<int, int>, std::vector<PointXyzi>> squares;
  for (const Eigen::Vector3d& point_m : points_map_m) {
    const Eigen::Vector3f p_m = (point_m + shift).cast<float>();
    squares[{corner_m(p_m.x()), corner_m(p_m.y())}].push_back({p_m.x(), p_m.y(), p_m.z(), 0.0F});
  }
  AutowareMap map;
  for (auto& [corner, points] : squares) {
    const auto& [x_m, y_m] = corner;
    map.squares.push_back(
        {std::to_string(x_m) + "_" + std::to_string(y_m) + ".pcd", x_m, y_m, std::move(points)});
  }
  map.metadata_yaml = metadata_of(map.squares);
  map.projector_yaml = std::move(projector);
  return map;
}

}  // namespace sightline
