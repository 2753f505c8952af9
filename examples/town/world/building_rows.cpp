// Rows are filled from one end: a house that does not fit moves on a little and tries again, so
// rows break at side streets and corners by themselves.

#include <algorithm>
#include <limits>

#include "examples/town/world/buildings.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr double kBackgroundPitchM = 19.0;   // of the grid on which houses behind the rows stand
constexpr double kBackgroundReachM = 110.0;  // from the driven line: as far as a sensor sees

struct RowStyle {
  double shortest_m = 8.0, longest_m = 20.0;  // of a front
  double lowest_m = 8.0, highest_m = 20.0;
  double setback_m = 0.0;      // fronts stand back by up to this
  double gap_probability = 0;  // between two houses
};

RowStyle row_style(StreetKind kind) {
  switch (kind) {
    case StreetKind::kCanyon:
      return {12.0, 28.0, 14.0, 26.0, 0.3, 0.12};
    case StreetKind::kLane:
      return {8.0, 18.0, 6.0, 11.0, 0.35, 0.12};
    case StreetKind::kPlaza:
      return {14.0, 30.0, 10.0, 22.0, 1.5, 0.25};
    case StreetKind::kSmooth:
      return {45.0, 80.0, 4.0, 12.0, 0.0, 0.0};
    case StreetKind::kRepeating:
      return {45.0, 80.0, 9.0, 18.0, 0.0, 0.0};
    case StreetKind::kAvenue:
      return {14.0, 30.0, 12.0, 26.0, 1.0, 0.2};
    case StreetKind::kSide:
      break;
  }
  return {8.0, 20.0, 7.0, 16.0, 1.0, 0.2};
}

bool is_free(const Footprint& place, const TownPlan& plan, const std::vector<Building>& built) {
  const auto blocks = [&](const Footprint& other) { return overlaps(place, other); };
  for (const Street& street : plan.streets) {
    if (blocks(corridor(street))) return false;
  }
  return std::none_of(built.begin(), built.end(),
                      [&](const Building& building) { return blocks(building.footprint); });
}

// A house on one side of a street. `side` is +1 on the left.
Footprint footprint_at(const Street& street, double along_m, double front_m, double setback_m,
                       double side) {
  constexpr double kDepthM = 12.0;
  // A hair behind the facade line, so that a row does not touch its own street.
  const double facade_m = (side > 0.0 ? street.left_m : street.right_m) + 1e-3 + setback_m;
  Footprint footprint;
  footprint.centre_m = street.at(along_m + 0.5 * front_m, side * (facade_m + 0.5 * kDepthM));
  // Local -y is the front: on the left of the street it looks to the right.
  footprint.yaw_rad = street.heading_rad + (side > 0.0 ? 0.0 : std::numbers::pi);
  footprint.half_length_m = 0.5 * front_m;
  footprint.half_width_m = 0.5 * kDepthM;
  return footprint;
}

void build_row(std::vector<Building>& built, const TownPlan& plan, const Street& street,
               double side, Random& random) {
  const RowStyle style = row_style(street.kind);
  constexpr double kStepM = 1.0;
  constexpr double kShortestM = 5.0;
  constexpr double kDepthM = 12.0;  // around a corner a row goes on to the back of the other
  double along_m = street.before_m > 0.0 ? -street.before_m - kDepthM : 0.0;
  const double end_m = street.length_m + (street.after_m > 0.0 ? street.after_m + kDepthM : 0.0);
  while (along_m < end_m - kShortestM) {
    const double setback_m = style.setback_m * random.uniform();
    const double wanted_m = random.uniform(style.shortest_m, style.longest_m);
    double front_m = std::min(wanted_m, end_m - along_m);
    Footprint place = footprint_at(street, along_m, front_m, setback_m, side);
    while (front_m >= kShortestM && !is_free(place, plan, built)) {
      front_m -= kStepM;
      place = footprint_at(street, along_m, front_m, setback_m, side);
    }
    if (front_m < kShortestM) {
      along_m += kStepM;
      continue;
    }
    built.push_back({place, random.uniform(style.lowest_m, style.highest_m), street.kind, false});
    along_m += front_m + 1e-3;
    if (random.uniform() < style.gap_probability) along_m += random.uniform(2.0, 6.0);
  }
}

double distance_to_line_m(const DrivenLine& line, const Eigen::Vector2d& point_m) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < line.points.size(); i += 32) {
    nearest = std::min(nearest, (line.points[i].position_m - point_m).norm());
  }
  return nearest;
}

void build_background(std::vector<Building>& built, const TownPlan& plan, Random& random) {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const LinePoint& point : plan.line.points) {
    low = low.min(point.position_m.array());
    high = high.max(point.position_m.array());
  }
  const double town_yaw = plan.streets.front().heading_rad + random.uniform(-0.3, 0.3);
  for (double x = low.x() - kBackgroundReachM; x < high.x() + kBackgroundReachM;
       x += kBackgroundPitchM) {
    for (double y = low.y() - kBackgroundReachM; y < high.y() + kBackgroundReachM;
         y += kBackgroundPitchM) {
      Footprint place;
      place.centre_m =
          Eigen::Vector2d(x + random.uniform(-3.0, 3.0), y + random.uniform(-3.0, 3.0));
      place.yaw_rad = town_yaw + random.uniform(-0.1, 0.1);
      place.half_length_m = random.uniform(4.0, 8.5);
      place.half_width_m = random.uniform(4.0, 7.0);
      const double height_m = random.uniform(5.0, 28.0);
      const bool is_kept = random.uniform() < 0.8;
      if (!is_kept || distance_to_line_m(plan.line, place.centre_m) > kBackgroundReachM) continue;
      if (!is_free(place, plan, built)) continue;
      built.push_back({place, height_m, StreetKind::kSide, true});
    }
  }
}

}  // namespace

std::vector<Building> place_buildings(std::uint64_t seed, const TownPlan& plan) {
  std::vector<Building> built;
  for (std::size_t i = 0; i < plan.streets.size(); ++i) {
    for (const double side : {1.0, -1.0}) {
      Random random(mix(mix(seed, 0x726f7773ULL), 2 * i + (side > 0.0 ? 1 : 0)));
      build_row(built, plan, plan.streets[i], side, random);
    }
  }
  Random random(mix(seed, 0x6261636bULL));
  build_background(built, plan, random);
  return built;
}

}  // namespace sightline::town
