#include "compiler/views/exports/export_frame.h"

#include <string>

#include "formats/reader/map_layout.h"

namespace sightline {

Eigen::Vector3d export_origin_m(const MapFrame& frame) {
  const Eigen::Vector3d& at_m = frame.origin_world_m;
  const std::array<double, 3> taken_m = export_origin_world_m({at_m.x(), at_m.y(), at_m.z()});
  return {taken_m[0], taken_m[1], taken_m[2]};
}

Eigen::Vector3d export_shift_m(const MapFrame& frame) {
  return frame.origin_world_m - export_origin_m(frame);
}

void to_world(const MapFrame& frame, Table& table) {
  constexpr const char* kPrefixes[] = {"", "p_", "mean_"};
  bool has_positions = false;
  constexpr const char* kAxes[] = {"x_m", "y_m", "z_m"};
  for (std::size_t column = 0; column < table.columns.size(); ++column) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (const char* prefix : kPrefixes) {
        if (table.columns[column] != std::string(prefix) + kAxes[axis]) continue;
        has_positions = true;
        for (std::vector<Cell>& row : table.rows) {
          if (auto* value = std::get_if<double>(&row[column])) {
            *value += frame.origin_world_m[axis];
          }
        }
      }
    }
  }
  if (has_positions) table.facts.emplace_back("positions_are", "world coordinates, m");
}

Result<void> add_degrees(const Sites& sites, const World& world, Table& table) {
  if (world.kind == WorldKind::kLocal) return {};
  for (const char* name : {"longitude_deg", "latitude_deg", "height_m"}) {
    table.columns.emplace_back(name);
  }
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Eigen::Vector3d p_world_m = sites.frame.world_m(sites.sites[i].p_map_m);
    SIGHTLINE_ASSIGN(const Geodetic point, to_geodetic(world, p_world_m));
    for (const double value : {point.longitude_deg, point.latitude_deg, point.altitude_m}) {
      table.rows[i].emplace_back(value);
    }
  }
  return {};
}

}  // namespace sightline
