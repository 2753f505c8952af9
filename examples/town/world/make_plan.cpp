// The route is a chain of straight streets. It runs towards +x as a whole: it may turn to +-90
// degrees but always turns back, so it never meets itself. Corners are rounded as a car would. A
// round route is four such sides around a block of houses instead.

#include "examples/town/world/make_plan.h"

#include <algorithm>
#include <cmath>

#include "examples/town/world/mesh.h"
#include "examples/town/world/plan_route.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

// Which way the next street of the route heads.
struct Compass {
  double lean_rad = 0.0;     // small bends add up here, within 30 degrees
  int quarter = 0;           // -1, 0, +1: right, ahead, left
  int last_turn = 0;         // the last quarter that was not 0
  double ahead_run_m = 0.0;  // since the last time ahead began

  [[nodiscard]] double heading_rad() const { return lean_rad + quarter * 0.5 * std::numbers::pi; }
};

void turn(Compass& compass, Random& random) {
  if (compass.quarter != 0) {
    compass.quarter = 0;
    compass.ahead_run_m = 0.0;
    return;
  }
  const int side = random.below(2) == 0 ? 1 : -1;
  // To turn back towards where it came from the route must first have gone far ahead.
  const bool may_choose = compass.last_turn == 0 || compass.ahead_run_m > 140.0;
  compass.quarter = may_choose ? side : compass.last_turn;
  compass.last_turn = compass.quarter;
}

void bend(Compass& compass, Random& random) {
  const double by = to_radians(random.uniform(8.0, 22.0));
  const bool leans_left = compass.lean_rad > 0.0;
  compass.lean_rad += leans_left ? -by : by;
}

// Lays streets end to end until the line through them is long enough; returns the joints between.
std::vector<Joint> lay_route(TownPlan& plan, double length_m, Random& random) {
  Deck<StreetKind> kinds({StreetKind::kCanyon, StreetKind::kLane, StreetKind::kPlaza,
                          StreetKind::kSmooth, StreetKind::kRepeating, StreetKind::kAvenue});
  Deck<Joint> joints({Joint::kTurn, Joint::kCrossing, Joint::kBend, Joint::kTurn, Joint::kCrossing,
                      Joint::kPlain});
  Compass compass;
  std::vector<Joint> between;
  double laid_m = 0.0;
  Eigen::Vector2d node_m = Eigen::Vector2d::Zero();
  // Rounded corners shorten the line, by less than 8 m each.
  while (laid_m < length_m + 8.0 * static_cast<double>(between.size()) + 10.0) {
    if (!plan.streets.empty()) {
      between.push_back(joints.deal(random));
      if (between.back() == Joint::kTurn) turn(compass, random);
      if (between.back() == Joint::kBend) bend(compass, random);
    }
    Street street = draw_street(kinds.deal(random), random);
    street.start_m = node_m;
    street.heading_rad = compass.heading_rad();
    node_m = street.at(street.length_m, 0.0);
    laid_m += street.length_m;
    if (compass.quarter == 0) compass.ahead_run_m += street.length_m;
    plan.streets.push_back(street);
  }
  return between;
}

// Four sides, with the first one's middle as the start, each of streets about as long as others.
std::vector<Joint> lay_round(TownPlan& plan, double lap_m, Random& random) {
  constexpr double kLongSide = 0.55;
  constexpr double kCustomaryM = 80.0;
  const double quarter = 0.5 * std::numbers::pi;
  const double radius_m = corner_radius_m(quarter);
  // What the sides are longer than the line, which cuts the corners.
  const double cut_m = 4.0 * (2.0 * tangent_length_m(quarter, radius_m) - quarter * radius_m);
  const double half_m = 0.5 * (lap_m + cut_m);
  Deck<StreetKind> kinds({StreetKind::kCanyon, StreetKind::kLane, StreetKind::kPlaza,
                          StreetKind::kSmooth, StreetKind::kRepeating, StreetKind::kAvenue});
  std::vector<Joint> between;
  Eigen::Vector2d node_m = Eigen::Vector2d::Zero();
  for (int side = 0; side <= 4; ++side) {
    double side_m = (side % 2 == 0 ? kLongSide : 1.0 - kLongSide) * half_m;
    if (side % 4 == 0) side_m *= 0.5;
    const int count = std::max(1, static_cast<int>(std::lround(side_m / kCustomaryM)));
    for (int i = 0; i < count; ++i) {
      if (!plan.streets.empty()) between.push_back(i == 0 ? Joint::kTurn : Joint::kPlain);
      Street street = draw_street(kinds.deal(random), random);
      street.length_m = side_m / count;
      street.start_m = node_m;
      street.heading_rad = side * quarter;
      node_m = street.at(street.length_m, 0.0);
      plan.streets.push_back(street);
    }
  }
  return between;
}

// Corners and what leaves the route between its streets.
void join_streets(TownPlan& plan, const std::vector<Joint>& between, Random& random) {
  for (std::size_t i = 0; i < between.size(); ++i) {
    if (between[i] == Joint::kTurn) widen_corner(plan.streets[i], plan.streets[i + 1]);
    const Street before = plan.streets[i];
    const Street after = plan.streets[i + 1];
    add_side_streets(plan, between[i], before, after, random);
  }
}

}  // namespace

TownPlan make_plan(std::uint64_t seed, double length_m) {
  Random random(mix(seed, 0x706c616eULL));
  TownPlan plan;
  const std::vector<Joint> between = lay_route(plan, length_m, random);
  const std::size_t on_route = plan.streets.size();
  plan.line = trace_line(plan.streets, on_route, 0.0);
  join_streets(plan, between, random);
  // The town does not end where the drive does.
  const Street last = plan.streets[on_route - 1];
  add_side_street(plan, Eigen::Vector2d::Zero(), plan.streets[0].heading_rad + std::numbers::pi,
                  random);
  add_side_street(plan, last.at(last.length_m, 0.0), last.heading_rad, random);
  return plan;
}

TownPlan make_round_plan(std::uint64_t seed, double lap_m) {
  Random random(mix(seed, 0x726f756eULL));
  TownPlan plan;
  const std::vector<Joint> between = lay_round(plan, lap_m, random);
  // Beyond the end it is the beginning again: the last step of the line must have two ends.
  plan.line = trace_line(plan.streets, plan.streets.size(), 2.0 * kLineStepM);
  plan.line.lap_m = lap_m;
  join_streets(plan, between, random);
  return plan;
}

}  // namespace sightline::town
