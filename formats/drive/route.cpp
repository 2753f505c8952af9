#include "formats/drive/route.h"

namespace sightline {

Result<void> validate(const Route& route) {
  if (route.lines.empty()) return invalid_artifact("found a route without a line", route.name);
  for (const RouteLine& line : route.lines) {
    if (line.heights > RouteHeights::kVehicle) {
      return invalid_artifact("unknown heights", line.name);
    }
    if (line.points_world_m.size() < 2) {
      return invalid_artifact("found " + std::to_string(line.points_world_m.size()) +
                                  " points of a line, expected two or more",
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
  static constexpr const char* kHeights[] = {"none", "road", "vehicle"};
  Table table{"route", {"line", "name", "heights", "both_ways", "x_m", "y_m", "z_m"}, {}, {}};
  table.facts = {{"name", route.name}};
  for (std::size_t i = 0; i < route.lines.size(); ++i) {
    const RouteLine& line = route.lines[i];
    for (const Eigen::Vector3d& point_m : line.points_world_m) {
      table.rows.push_back({static_cast<std::int64_t>(i), line.name,
                            kHeights[static_cast<std::size_t>(line.heights)],
                            std::int64_t{line.is_both_ways ? 1 : 0}, point_m.x(), point_m.y(),
                            point_m.z()});
    }
  }
  return table;
}

void encode(const Route& route, ByteWriter& writer) {
  writer.put_string(route.name);
  writer.put<std::uint64_t>(route.lines.size());
  for (const RouteLine& line : route.lines) {
    writer.put_string(line.name);
    writer.put(static_cast<std::uint8_t>(line.heights));
    writer.put(static_cast<std::uint8_t>(line.is_both_ways ? 1 : 0));
    writer.put<std::uint64_t>(line.points_world_m.size());
    for (const Eigen::Vector3d& point_m : line.points_world_m) {
      for (int axis = 0; axis < 3; ++axis) writer.put(point_m[axis]);
    }
  }
}

void decode(ByteReader& reader, Route& route) {
  constexpr std::size_t kLeastLine = 2 * sizeof(std::uint64_t) + 2;
  reader.get_string(route.name);
  route.lines.resize(reader.get_count(kLeastLine));
  for (RouteLine& line : route.lines) {
    std::uint8_t heights = 0;
    std::uint8_t is_both_ways = 0;
    reader.get_string(line.name);
    reader.get(heights);
    reader.get(is_both_ways);
    if (is_both_ways > 1) reader.fail();
    line.heights = static_cast<RouteHeights>(heights);
    line.is_both_ways = is_both_ways == 1;
    line.points_world_m.resize(reader.get_count(3 * sizeof(double)));
    for (Eigen::Vector3d& point_m : line.points_world_m) {
      for (int axis = 0; axis < 3; ++axis) reader.get(point_m[axis]);
    }
  }
}

}  // namespace sightline
