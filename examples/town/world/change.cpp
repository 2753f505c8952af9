#include "examples/town/world/change.h"

#include <algorithm>
#include <limits>

#include "formats/base/random.h"

namespace sightline::town {
namespace {

double nearest_s_m(const DrivenLine& line, const Eigen::Vector2d& point_m) {
  double nearest_m = std::numeric_limits<double>::infinity();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const double distance_m = (line.points[i].position_m - point_m).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = i;
  }
  return static_cast<double>(nearest) * kLineStepM;
}

bool stands_in_stretch(const TownChange& change, const TownPlan& plan, const Building& building) {
  return !building.is_background &&
         change.is_at(nearest_s_m(plan.line, building.footprint.centre_m));
}

// Another front on the same plot: nothing comes nearer to the street or to a neighbour.
void rebuild(Building& building, Random random) {
  constexpr double kMostSetbackM = 2.0;
  building.height_m *= random.uniform(0.6, 1.5);
  const double setback_m = random.uniform() < 0.5 ? 0.0 : random.uniform(0.5, kMostSetbackM);
  Footprint& place = building.footprint;
  place.half_width_m -= 0.5 * setback_m;
  place.centre_m += 0.5 * setback_m * left_of(direction(place.yaw_rad));
}

}  // namespace

std::set<std::size_t> change_buildings(const TownChange& change, std::uint64_t seed,
                                       const TownPlan& plan, std::vector<Building>& buildings) {
  std::set<std::size_t> in_stretch;
  for (std::size_t b = 0; b < buildings.size() && change.is_any(); ++b) {
    if (stands_in_stretch(change, plan, buildings[b])) in_stretch.insert(b);
  }
  const auto longest =
      std::max_element(in_stretch.begin(), in_stretch.end(), [&](std::size_t a, std::size_t b) {
        return buildings[a].footprint.half_length_m < buildings[b].footprint.half_length_m;
      });
  if (change.removes_wall && longest != in_stretch.end()) {
    buildings[*longest].is_gone = true;
    in_stretch.erase(longest);
  }
  if (!change.rebuilds) return {};
  for (const std::size_t b : in_stretch) rebuild(buildings[b], Random(mix(seed, b)));
  return in_stretch;
}

std::vector<Pose2d> added_cars(const TownChange& change, std::uint64_t seed, const TownPlan& plan) {
  constexpr double kFromKerbM = 1.1;
  constexpr double kFarthestM = 6.0;  // on a plaza the kerb is far away
  std::vector<Pose2d> cars;
  if (!change.is_any()) return cars;
  const double pitch_m = (change.to_m - change.from_m) / std::max(1, change.added_cars);
  for (int i = 0; i < change.added_cars; ++i) {
    Random random(mix(seed, static_cast<std::uint64_t>(i)));
    const double s_m = change.from_m + (i + random.uniform(0.3, 0.7)) * pitch_m;
    const LinePoint point = plan.line.at(s_m);
    const Street& street = plan.street_at(s_m);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double kerb_m = side > 0.0 ? street.kerb_left_m : street.kerb_right_m;
    const double lateral_m = side * std::min(kFarthestM, kerb_m - kFromKerbM);
    cars.push_back({point.position_m + lateral_m * left_of(direction(point.heading_rad)),
                    point.heading_rad + random.uniform(-0.05, 0.05)});
  }
  return cars;
}

}  // namespace sightline::town
