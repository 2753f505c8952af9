#include "formats/foreign/maps/foreign_nds.h"

namespace sightline {

Result<void> validate(const ForeignNds& map) {
  if (!(map.cell_m > 0.0)) {
    return Error{ErrorCode::kInvalidArtifact, "a cell has no size", "", map.name};
  }
  for (std::size_t i = 0; i < map.nds.size(); ++i) {
    const ForeignNd& nd = map.nds[i];
    const bool is_inside =
        nd.mean_in_cell_m.minCoeff() >= 0.0 && nd.mean_in_cell_m.maxCoeff() < map.cell_m;
    const bool ascends = i == 0 || map.nds[i - 1].key_world < nd.key_world;
    if (is_inside && ascends && nd.point_count >= 2 && nd.covariance_m2.allFinite()) continue;
    return Error{ErrorCode::kInvalidArtifact,
                 "a mean outside its cell, a cell out of order or without 2 points, or a "
                 "covariance that is not finite",
                 "", "nd " + std::to_string(i)};
  }
  return {};
}

Table dump(const ForeignNds& map) {
  Table table{"foreign-nds", {"key_x", "key_y", "key_z", "point_count"}, {}, {}};
  for (const char axis : {'x', 'y', 'z'}) {
    table.columns.push_back(std::string("mean_in_cell_") + axis + "_m");
  }
  table.facts = {{"name", map.name},
                 {"world", map.world},
                 {"cell_m", map.cell_m},
                 {"point_count", static_cast<std::int64_t>(map.point_count)},
                 {"single_point_count", static_cast<std::int64_t>(map.single_point_count)}};
  for (const ForeignNd& nd : map.nds) {
    table.rows.push_back({std::int64_t{nd.key_world.x}, std::int64_t{nd.key_world.y},
                          std::int64_t{nd.key_world.z}, std::int64_t{nd.point_count},
                          nd.mean_in_cell_m.x(), nd.mean_in_cell_m.y(), nd.mean_in_cell_m.z()});
  }
  return table;
}

}  // namespace sightline
