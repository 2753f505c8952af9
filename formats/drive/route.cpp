#include "formats/drive/route.h"

#include "formats/record/cells.h"

namespace sightline {

Result<void> validate(const Route& route) {
  if (route.lines.empty()) return invalid_artifact("found a route without a line", route.name);
  for (const RouteLine& line : route.lines) {
    if (line.points_world_m.size() < 2) {
      return invalid_artifact(
          concat("found ", line.points_world_m.size(), " points of a line, expected two or more"),
          line.name);
    }
    for (const Eigen::Vector3d& point_m : line.points_world_m) {
      if (!point_m.allFinite()) {
        return invalid_artifact("found a point that is not finite", line.name);
      }
    }
  }
  return {};
}

Table dump(const Route& route) {
  Table table{"route", {"line", "name", "heights", "both_ways", "x_m", "y_m", "z_m"}, {}, {}};
  table.facts = {{"name", route.name}};
  for (std::size_t i = 0; i < route.lines.size(); ++i) {
    const RouteLine& line = route.lines[i];
    for (const Eigen::Vector3d& point_m : line.points_world_m) {
      table.rows.push_back({static_cast<std::int64_t>(i), line.name, cell_of(line.heights),
                            cell_of(line.is_both_ways), point_m.x(), point_m.y(), point_m.z()});
    }
  }
  return table;
}

}  // namespace sightline
