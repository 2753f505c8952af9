#include "examples/town/world/plan_route.h"

#include <cmath>

#include "examples/town/world/mesh.h"
#include "formats/base/portable_math.h"

namespace sightline::town {
namespace {

constexpr double kSideStreetLengthM = 120.0;  // beyond the longest range of a sensor
constexpr double kTurnRadiusM = 8.0;          // of a car in a town
constexpr double kBendRadiusM = 40.0;

struct Widths {
  double facade_to_facade_m = 0.0;
  double pavement_m = 0.0;     // on each side; 0: none
  double lane_offset_m = 0.0;  // how far right of the middle is driven
};

Widths draw_widths(StreetKind kind, Random& random) {
  switch (kind) {
    case StreetKind::kCanyon:
      return {random.uniform(18.0, 26.0), random.uniform(2.5, 4.5), 1.8};
    case StreetKind::kLane:
      return {random.uniform(6.0, 8.0), 0.0, 0.2};
    case StreetKind::kPlaza:
      return {random.uniform(60.0, 84.0), 0.0, random.uniform(-6.0, 6.0)};
    case StreetKind::kSmooth:
    case StreetKind::kRepeating:
      return {random.uniform(14.0, 20.0), random.uniform(2.0, 3.0), 1.8};
    case StreetKind::kAvenue:
      return {random.uniform(36.0, 50.0), random.uniform(6.0, 9.0), random.uniform(2.5, 5.0)};
    case StreetKind::kSide:
      break;
  }
  return {random.uniform(10.0, 16.0), random.uniform(1.5, 2.5), 0.0};
}

// Appends points at exact steps of arc length; `overshoot_m` carries what a piece left over.
class LineTracer {
 public:
  void straight(const Eigen::Vector2d& from_m, double heading_rad, double length_m) {
    for (; overshoot_m_ <= length_m; overshoot_m_ += kLineStepM) {
      line.points.push_back({from_m + overshoot_m_ * direction(heading_rad), heading_rad});
    }
    overshoot_m_ -= length_m;
  }
  void arc(const Eigen::Vector2d& from_m, double heading_rad, double angle_rad, double radius_m) {
    const double sign = angle_rad > 0.0 ? 1.0 : -1.0;
    const Eigen::Vector2d centre_m = from_m + sign * radius_m * left_of(direction(heading_rad));
    const double length_m = radius_m * std::abs(angle_rad);
    for (; overshoot_m_ <= length_m; overshoot_m_ += kLineStepM) {
      const double yaw = heading_rad + sign * overshoot_m_ / radius_m;
      line.points.push_back({centre_m - sign * radius_m * left_of(direction(yaw)), yaw});
    }
    overshoot_m_ -= length_m;
  }
  DrivenLine line;

 private:
  double overshoot_m_ = 0.0;
};

}  // namespace

Street draw_street(StreetKind kind, Random& random) {
  const Widths widths = draw_widths(kind, random);
  Street street;
  street.kind = kind;
  street.left_m = 0.5 * widths.facade_to_facade_m + widths.lane_offset_m;
  street.right_m = 0.5 * widths.facade_to_facade_m - widths.lane_offset_m;
  street.kerb_left_m = street.left_m - widths.pavement_m;
  street.kerb_right_m = street.right_m - widths.pavement_m;
  street.length_m = kind == StreetKind::kSide ? kSideStreetLengthM : random.uniform(62.0, 108.0);
  return street;
}

void add_side_street(TownPlan& plan, const Eigen::Vector2d& start_m, double heading_rad,
                     Random& random) {
  Street street = draw_street(StreetKind::kSide, random);
  street.start_m = start_m;
  street.heading_rad = heading_rad;
  plan.streets.push_back(street);
}

void add_side_streets(TownPlan& plan, Joint joint, const Street& before, const Street& after,
                      Random& random) {
  const Eigen::Vector2d node_m = after.start_m;
  if (joint == Joint::kCrossing) {
    const double middle = 0.5 * (before.heading_rad + after.heading_rad);
    const double skew = to_radians(random.uniform(-12.0, 12.0));
    const std::uint64_t which = random.below(4);
    if (which != 0) add_side_street(plan, node_m, middle + 0.5 * std::numbers::pi + skew, random);
    if (which != 1) add_side_street(plan, node_m, middle - 0.5 * std::numbers::pi + skew, random);
  }
  if (joint == Joint::kTurn) {
    if (random.uniform() < 0.6) add_side_street(plan, node_m, before.heading_rad, random);
    if (random.uniform() < 0.6) {
      add_side_street(plan, node_m, after.heading_rad + std::numbers::pi, random);
    }
  }
}

double tangent_length_m(double angle_rad, double radius_m) {
  const SinCos half = portable_sin_cos(0.5 * std::abs(angle_rad));
  return radius_m * half.sin / half.cos;
}

double corner_radius_m(double angle_rad) {
  return std::abs(angle_rad) > to_radians(60.0) ? kTurnRadiusM : kBendRadiusM;
}

void widen_corner(Street& before, Street& after) {
  const bool turns_left = after.heading_rad > before.heading_rad;
  before.after_m = turns_left ? after.right_m : after.left_m;
  after.before_m = turns_left ? before.right_m : before.left_m;
}

DrivenLine trace_line(std::vector<Street>& streets, std::size_t on_route, double beyond_m) {
  LineTracer tracer;
  double s_m = 0.0;
  double taken_m = 0.0;  // by the corner at the street's start
  for (std::size_t i = 0; i < on_route; ++i) {
    Street& street = streets[i];
    street.route_from_m = s_m;
    const bool is_last = i + 1 == on_route;
    const double angle = is_last ? 0.0 : streets[i + 1].heading_rad - street.heading_rad;
    const double radius_m = corner_radius_m(angle);
    const double takes_m = tangent_length_m(angle, radius_m);
    tracer.straight(street.at(taken_m, 0.0), street.heading_rad,
                    street.length_m - taken_m - takes_m + (is_last ? beyond_m : 0.0));
    if (angle != 0.0) {
      tracer.arc(street.at(street.length_m - takes_m, 0.0), street.heading_rad, angle, radius_m);
    }
    s_m = static_cast<double>(tracer.line.points.size()) * kLineStepM;
    street.route_to_m = s_m;
    taken_m = takes_m;
  }
  return std::move(tracer.line);
}

}  // namespace sightline::town
