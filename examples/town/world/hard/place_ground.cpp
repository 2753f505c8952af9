#include <algorithm>
#include <array>

#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

constexpr double kReach_m = 100.0;  // of the ground, from the line
constexpr double kAlong_m = 1.0;    // size of a cell
constexpr double kValley_m = 15.0;  // below a bridge
constexpr double kSlope_m = 25.0;   // along the road, from its ends down to there

// Fine where the ground is seen steeply.
std::vector<double> laterals_m(double right_m, double left_m) {
  constexpr std::array<double, 9> kFar_m = {14.0, 17.0, 21.0, 26.0, 33.0, 42.0, 55.0, 75.0, 100.0};
  std::vector<double> all = {right_m, left_m};
  for (int i = -12; i <= 12; ++i) all.push_back(static_cast<double>(i));
  for (const double far_m : kFar_m) all.insert(all.end(), {-far_m, far_m});
  std::erase_if(all, [&](double at_m) { return at_m < right_m || at_m > left_m; });
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// Height of the ground above the line's, by arc length and lateral.
using Relief = double (*)(const Road& road, const Place& place, double s_m, double lateral_m);

double uneven_m(const Road& road, const Place& /*place*/, double s_m, double lateral_m) {
  return road.ground_m(s_m, lateral_m);
}

double valley_m(const Road& road, const Place& place, double s_m, double lateral_m) {
  const double from_end_m = std::min(s_m - place.from_m, place.to_m - s_m);
  const double share = std::clamp(from_end_m / kSlope_m, 0.0, 1.0);
  return road.ground_m(s_m, lateral_m) - kValley_m * share * share * (3.0 - 2.0 * share);
}

void add_strip(TownMesh& mesh, const Road& road, const Place& place,
               const std::vector<double>& laterals, Relief relief) {
  const int steps = std::max(1, static_cast<int>(place.length_m() / kAlong_m + 0.5));
  const auto s_at = [&](int step) { return place.from_m + place.length_m() * step / steps; };
  const auto corner = [&](int step, double lateral_m) -> Eigen::Vector3d {
    return road.on(s_at(step), lateral_m, relief(road, place, s_at(step), lateral_m));
  };
  for (int step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i + 1 < laterals.size(); ++i) {
      add_quad(mesh,
               {corner(step, laterals[i]), corner(step + 1, laterals[i]),
                corner(step + 1, laterals[i + 1]), corner(step, laterals[i + 1])},
               Label::kGround);
    }
  }
}

}  // namespace

void add_place_ground(TownMesh& mesh, const Road& road, const Place& place) {
  switch (place.kind) {
    case PlaceKind::kCarPark:
      return;
    case PlaceKind::kTunnel: {
      const Tube tube = tube_of(road.seed, place);
      add_strip(mesh, road, place, laterals_m(-tube.right_m, tube.left_m), uneven_m);
      return;
    }
    case PlaceKind::kBridge:
      add_strip(mesh, road, place, laterals_m(-kDeckRight_m, kDeckLeft_m), uneven_m);
      add_strip(mesh, road, place, laterals_m(kDeckLeft_m, kReach_m), valley_m);
      add_strip(mesh, road, place, laterals_m(-kReach_m, -kDeckRight_m), valley_m);
      return;
    default:
      add_strip(mesh, road, place, laterals_m(-kReach_m, kReach_m), uneven_m);
  }
}

}  // namespace sightline::town
