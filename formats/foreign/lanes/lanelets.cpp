#include <cmath>
#include <utility>

#include "formats/foreign/lanes/lanelet_map.h"

namespace sightline {

Result<void> parse_lanelets(const RouteText& file, Route& route) {
  constexpr double kStep_m = 0.5;
  SIGHTLINE_ASSIGN(const LaneletMap map, read_lanelets(file, LaneletsRead::kForVehicles));
  double total_m = 0.0;
  for (const Lanelet& lanelet : map.lanelets) {
    total_m += lanelet.length_m;
    if (total_m > kLongestRoute_m) {
      return file.error(ErrorCode::kMalformedText, "its lanelets are longer than 10000 km");
    }
    const auto steps = static_cast<std::size_t>(std::ceil(lanelet.length_m / kStep_m));
    RouteLine line = line_of_points(
        "lanelet " + lanelet.id,
        middle_of(LineByShare(lanelet.left.points_m), LineByShare(lanelet.right.points_m), steps));
    if (line.points_world_m.size() < 2) continue;
    line.is_both_ways = lanelet.is_both_ways;
    route.lines.push_back(std::move(line));
  }
  if (!route.lines.empty()) return {};
  return file.error(
      ErrorCode::kMissingField,
      "found no lanelet for vehicles among " + std::to_string(map.relation_count) + " relations");
}

}  // namespace sightline
