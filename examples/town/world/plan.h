#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "examples/town/world/ground.h"

// Where the streets of a town are, and the line that drives follow through them.

namespace sightline::town {

enum class StreetKind {
  kCanyon,     // 18-26 m between tall, cluttered facades, parked cars
  kLane,       // 6-8 m, walls close by, no pavement
  kPlaza,      // open, few things stand on it
  kSmooth,     // 14-20 m between walls without any feature
  kRepeating,  // 14-20 m, the same 3 m of facade again and again
  kAvenue,     // 36-50 m, rows of trees
  kSide,       // a street that crosses the driven line or leaves it
};
std::string_view street_kind_name(StreetKind kind);

// A straight street in its own frame: `along` from its start, `lateral` to the left of the line
// that is driven (which is not its middle).
struct Street {
  StreetKind kind = StreetKind::kCanyon;
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  double length_m = 0.0;
  double left_m = 0.0;       // lateral of the left facades
  double right_m = 0.0;      // -lateral of the right facades
  double kerb_left_m = 0.0;  // where the roadway ends; at the facade where there is no pavement
  double kerb_right_m = 0.0;
  double before_m = 0.0;  // how far the street goes on beyond its ends, where a corner widens it
  double after_m = 0.0;
  double route_from_m = 0.0;  // arc length of the driven line; both 0 for side streets
  double route_to_m = 0.0;

  [[nodiscard]] Eigen::Vector2d at(double along_m, double lateral_m) const;
  [[nodiscard]] bool is_on_route() const { return route_to_m > route_from_m; }
  [[nodiscard]] bool has_pavement_left() const { return kerb_left_m < left_m; }
  [[nodiscard]] bool has_pavement_right() const { return kerb_right_m < right_m; }
};

struct LinePoint {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  double height_m = 0.0;  // 0 in a town of streets
  double slope = 0.0;     // rise for each metre of the line
};

// The driven line, sampled every kLineStepM of arc length; it goes on straight beyond both ends, or
// begins again where it closes.
inline constexpr double kLineStepM = 0.25;
struct DrivenLine {
  std::vector<LinePoint> points;
  double lap_m = 0.0;  // once around; 0 where it does not close

  [[nodiscard]] double length_m() const;
  [[nodiscard]] LinePoint at(double s_m) const;
};

struct TownPlan {
  std::vector<Street> streets;  // those of the route first, in order
  DrivenLine line;

  // The street of the route that is driven at an arc length; the first or last beyond the ends.
  [[nodiscard]] const Street& street_at(double s_m) const;
};

// The ground that a street keeps free of buildings, facade to facade; and its roadway alone.
Footprint corridor(const Street& street);
Footprint roadway(const Street& street);

}  // namespace sightline::town
