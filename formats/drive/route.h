#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/record/fields.h"

namespace sightline {

// What the heights of a route's points are.
enum class RouteHeights : std::uint8_t {
  kNone,     // there are none: z is 0 and says nothing
  kRoad,     // of the road's surface
  kVehicle,  // of the vehicle's origin, as poses tell
};
template <>
inline constexpr auto kNamesOf<RouteHeights> = enum_names("none", "road", "vehicle");

// A line that vehicles drive along, in its own direction.
struct RouteLine {
  std::string name;  // as its file calls it: "lanelet 17", "line 2"
  RouteHeights heights = RouteHeights::kNone;
  bool is_both_ways = false;                    // it is driven in the other direction too
  std::vector<Eigen::Vector3d> points_world_m;  // two or more, in the map's own coordinates
};
SIGHTLINE_FIELDS(RouteLine, name, heights, is_both_ways, points_world_m)

// Where places of a map are to be annotated, also without a drive there.
struct Route {
  std::string name;  // of its file
  std::vector<RouteLine> lines;
  std::vector<std::string> warnings;  // of what was left out when the file was read; not encoded
};
SIGHTLINE_SOME_FIELDS(Route, name, lines)
SIGHTLINE_ARTIFACT(Route, "route", 1)

// Error: invalid-artifact (no line, a line of fewer than two points, a point that is not finite).
Result<void> validate(const Route& route);
Table dump(const Route& route);

}  // namespace sightline
