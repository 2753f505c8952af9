#include "examples/town/world/plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "examples/town/world/mesh.h"

namespace sightline::town {
namespace {

Footprint band(const Street& street, double left_m, double right_m) {
  const double end_m = street.length_m + street.after_m;
  Footprint footprint;
  footprint.centre_m = street.at(0.5 * (end_m - street.before_m), 0.5 * (left_m - right_m));
  footprint.yaw_rad = street.heading_rad;
  footprint.half_length_m = 0.5 * (end_m + street.before_m);
  footprint.half_width_m = 0.5 * (left_m + right_m);
  return footprint;
}

double within_lap_m(double s_m, double lap_m) { return s_m - lap_m * std::floor(s_m / lap_m); }

}  // namespace

std::string_view street_kind_name(StreetKind kind) {
  constexpr std::array<std::string_view, 7> kNames = {"canyon",    "lane",   "plaza", "smooth",
                                                      "repeating", "avenue", "side"};
  return kNames[static_cast<std::size_t>(kind)];
}

Eigen::Vector2d Street::at(double along_m, double lateral_m) const {
  return start_m + along_m * direction(heading_rad) + lateral_m * left_of(direction(heading_rad));
}

double DrivenLine::length_m() const { return static_cast<double>(points.size() - 1) * kLineStepM; }

LinePoint DrivenLine::at(double s_m) const {
  if (lap_m > 0.0) s_m = within_lap_m(s_m, lap_m);
  const double clamped = std::clamp(s_m, 0.0, length_m());
  const std::size_t i = std::min(static_cast<std::size_t>(clamped / kLineStepM), points.size() - 2);
  const double fraction = clamped / kLineStepM - static_cast<double>(i);
  LinePoint point;
  point.position_m = (1.0 - fraction) * points[i].position_m + fraction * points[i + 1].position_m;
  point.heading_rad = std::lerp(points[i].heading_rad, points[i + 1].heading_rad, fraction);
  point.position_m += (s_m - clamped) * direction(point.heading_rad);
  return point;
}

const Street& TownPlan::street_at(double s_m) const {
  if (line.lap_m > 0.0) s_m = within_lap_m(s_m, line.lap_m);
  std::size_t i = 0;
  while (i + 1 < streets.size() && streets[i + 1].is_on_route() && s_m >= streets[i].route_to_m) {
    ++i;
  }
  return streets[i];
}

Footprint corridor(const Street& street) { return band(street, street.left_m, street.right_m); }

Footprint roadway(const Street& street) {
  return band(street, street.kerb_left_m, street.kerb_right_m);
}

}  // namespace sightline::town
