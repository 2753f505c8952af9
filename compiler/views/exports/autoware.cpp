#include "compiler/views/exports/autoware.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compiler/views/exports/export_frame.h"
#include "formats/reader/map_layout.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

int corner_m(float coordinate_m) {
  // Of the number as it is written: rounding to float may not move a point out of its square.
  return static_cast<int>(kAutowareSquare_m) *
         static_cast<int>(std::floor(static_cast<double>(coordinate_m) / kAutowareSquare_m));
}

std::string metadata_of(const std::vector<AutowareSquare>& squares) {
  std::string yaml = "x_resolution: 20.0\ny_resolution: 20.0\n";
  for (const AutowareSquare& square : squares) {
    yaml += fmt::format("{}: [{}, {}]\n", square.file, square.x_m, square.y_m);
  }
  return yaml;
}

std::string origin_yaml(const Geodetic& origin) {
  return concat(
      "vertical_datum: WGS84\nmap_origin:\n  latitude: ", format_double(origin.latitude_deg),
      "\n  longitude: ", format_double(origin.longitude_deg), "\n  altitude: 0.0\n");
}

// The square that the exported coordinates count from, also where the frame's origin, a tile at
// most before the first scan, lies outside of it.
Result<std::string> square_of(const MapFrame& frame, const World& world) {
  const Eigen::Vector3d corner_m = export_origin_m(frame);
  Eigen::Vector3d within_m = frame.origin_world_m;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    within_m[axis] =
        std::clamp(within_m[axis], corner_m[axis] + 1.0, corner_m[axis] + kExportSquare_m - 1.0);
  }
  return mgrs_square(world, within_m);
}

Result<std::string> projector_of(const MapFrame& frame, const World& world) {
  const Eigen::Vector3d taken_m = export_origin_m(frame);
  const std::string comment = fmt::format("# x and y are the recording's world minus ({}, {}) m\n",
                                          format_double(taken_m.x()), format_double(taken_m.y()));
  if (world.kind == WorldKind::kLocal) return comment + "projector_type: Local\n";
  if (world.kind == WorldKind::kEnu) {
    if (taken_m == Eigen::Vector3d::Zero()) {
      return "projector_type: LocalCartesian\n" +
             origin_yaml({world.latitude_deg, world.longitude_deg, 0.0});
    }
    return Error{ErrorCode::kBadArgument,
                 "world: the map is 100 km or more from the origin of this enu world; give an "
                 "origin near the route"};
  }
  SIGHTLINE_ASSIGN(const std::string square, square_of(frame, world));
  return concat(comment, "projector_type: MGRS\nvertical_datum: WGS84\nmgrs_grid: ", square, "\n");
}

}  // namespace

Result<AutowareMap> autoware_map(const std::vector<Eigen::Vector3d>& points_map_m,
                                 const MapFrame& frame, const World& world) {
  if (points_map_m.empty()) return Error{ErrorCode::kEmptyMap, "the map has no points"};
  SIGHTLINE_ASSIGN(std::string projector, projector_of(frame, world));
  const Eigen::Vector3d shift = export_shift_m(frame);
  std::map<std::pair<int, int>, std::vector<PointXyzi>> squares;
  for (const Eigen::Vector3d& point_m : points_map_m) {
    const Eigen::Vector3f p_m = (point_m + shift).cast<float>();
    squares[{corner_m(p_m.x()), corner_m(p_m.y())}].push_back({p_m.x(), p_m.y(), p_m.z(), 0.0F});
  }
  AutowareMap map;
  for (auto& [corner, points] : squares) {
    const auto& [x_m, y_m] = corner;
    map.squares.push_back({fmt::format("{}_{}.pcd", x_m, y_m), x_m, y_m, std::move(points)});
  }
  map.metadata_yaml = metadata_of(map.squares);
  map.projector_yaml = std::move(projector);
  return map;
}

}  // namespace sightline
