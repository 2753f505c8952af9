// The route is a chain of straight streets. It runs towards +x as a whole: it may turn to +-90
// degrees but always turns back, so it never meets itself. Corners are rounded as a car would.

#include "examples/town/plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "compiler/base/random.h"
#include "examples/town/mesh.h"

namespace sightline::town {
namespace {

enum class Joint { kTurn, kCrossing, kBend, kPlain };

constexpr double kSideStreetLengthM = 120.0;  // beyond the longest range of a sensor
constexpr double kTurnRadiusM = 8.0;          // of a car in a town
constexpr double kBendRadiusM = 40.0;

// Deals every value once in random order, then again in another.
template <class T>
class Deck {
 public:
  explicit Deck(std::vector<T> cards) : cards_(std::move(cards)) {}
  T deal(Random& random) {
    if (next_ == 0) {
      for (std::size_t i = cards_.size() - 1; i > 0; --i) {
        std::swap(cards_[i], cards_[random.below(i + 1)]);
      }
    }
    const T card = cards_[next_];
    next_ = (next_ + 1) % cards_.size();
    return card;
  }

 private:
  std::vector<T> cards_;
  std::size_t next_ = 0;
};

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

void add_side_street(TownPlan& plan, const Eigen::Vector2d& start_m, double heading_rad,
                     Random& random) {
  Street street = draw_street(StreetKind::kSide, random);
  street.start_m = start_m;
  street.heading_rad = heading_rad;
  plan.streets.push_back(street);
}

// Streets that leave a joint, so that the far field behind a corner is a street too.
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

// How much of a straight the rounding of its corner takes away.
double tangent_length_m(double angle_rad, double radius_m) {
  return radius_m * std::tan(0.5 * std::abs(angle_rad));
}

double corner_radius_m(double angle_rad) {
  return std::abs(angle_rad) > to_radians(60.0) ? kTurnRadiusM : kBendRadiusM;
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

// Rounds the corners, and tells each street its share of the line.
DrivenLine trace_line(std::vector<Street>& streets, std::size_t on_route) {
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
                    street.length_m - taken_m - takes_m);
    if (angle != 0.0) {
      tracer.arc(street.at(street.length_m - takes_m, 0.0), street.heading_rad, angle, radius_m);
    }
    s_m = static_cast<double>(tracer.line.points.size()) * kLineStepM;
    street.route_to_m = s_m;
    taken_m = takes_m;
  }
  return std::move(tracer.line);
}

Footprint band(const Street& street, double left_m, double right_m) {
  const double end_m = street.length_m + street.after_m;
  Footprint footprint;
  footprint.centre_m = street.at(0.5 * (end_m - street.before_m), 0.5 * (left_m - right_m));
  footprint.yaw_rad = street.heading_rad;
  footprint.half_length_m = 0.5 * (end_m + street.before_m);
  footprint.half_width_m = 0.5 * (left_m + right_m);
  return footprint;
}

// Lays streets end to end until the line through them is long enough; tells the joints between.
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

// Both streets at a corner reach to the other's outer side.
void widen_corner(Street& before, Street& after) {
  const bool turns_left = after.heading_rad > before.heading_rad;
  before.after_m = turns_left ? after.right_m : after.left_m;
  after.before_m = turns_left ? before.right_m : before.left_m;
}

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

TownPlan make_plan(std::uint64_t seed, double length_m) {
  Random random(mix(seed, 0x706c616eULL));
  TownPlan plan;
  const std::vector<Joint> between = lay_route(plan, length_m, random);
  const std::size_t on_route = plan.streets.size();
  plan.line = trace_line(plan.streets, on_route);
  for (std::size_t i = 0; i + 1 < on_route; ++i) {
    if (between[i] == Joint::kTurn) widen_corner(plan.streets[i], plan.streets[i + 1]);
    const Street before = plan.streets[i];
    const Street after = plan.streets[i + 1];
    add_side_streets(plan, between[i], before, after, random);
  }
  // The town does not end where the drive does.
  const Street last = plan.streets[on_route - 1];
  add_side_street(plan, Eigen::Vector2d::Zero(), plan.streets[0].heading_rad + std::numbers::pi,
                  random);
  add_side_street(plan, last.at(last.length_m, 0.0), last.heading_rad, random);
  return plan;
}

}  // namespace sightline::town
