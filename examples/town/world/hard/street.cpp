#include <algorithm>
#include <numbers>

#include "examples/town/world/buildings.h"
#include "examples/town/world/furniture.h"
#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

constexpr double kPavement_m = 2.0;

// Distances of the facades from the driven line.
struct Widths {
  double left_m = 11.0;
  double right_m = 8.0;

  [[nodiscard]] double facade_m(double side) const { return side > 0.0 ? left_m : right_m; }
  [[nodiscard]] double kerb_m(double side) const { return facade_m(side) - kPavement_m; }
};

Widths widths_of(std::uint64_t seed, const Place& place) {
  Random random(mix(mix(seed, 0x77696474ULL), static_cast<std::uint64_t>(place.from_m + 1000.0)));
  Widths widths;
  widths.left_m = random.uniform(10.0, 13.0);
  widths.right_m = random.uniform(7.5, 9.0);
  return widths;
}

// A house whose front begins at an arc length, on one side of the road (+1: left).
Building house_at(const Road& road, double s_m, double front_m, double facade_m, double side) {
  constexpr double kDepth_m = 10.0;
  const RoadPoint middle = road.at(s_m + 0.5 * front_m);
  const Eigen::Vector2d left = left_of(direction(middle.heading_rad));
  Building house;
  house.kind = StreetKind::kCanyon;
  house.footprint.centre_m =
      middle.position_m.head<2>() + side * (facade_m + 0.5 * kDepth_m) * left;
  // Its front looks along -y of its own frame.
  house.footprint.yaw_rad = middle.heading_rad + (side > 0.0 ? 0.0 : std::numbers::pi);
  house.footprint.half_length_m = 0.5 * front_m;
  house.footprint.half_width_m = 0.5 * kDepth_m;
  return house;
}

void add_row(TownMesh& mesh, const Road& road, const Place& place, double facade_m, double side,
             Random& random) {
  constexpr double kShortest_m = 5.0;
  double s_m = place.from_m;
  while (s_m < place.to_m - kShortest_m) {
    const double front_m = std::min(random.uniform(8.0, 15.0), place.to_m - s_m);
    const double setback_m = random.uniform(0.0, 0.8);
    Building house = house_at(road, s_m, front_m, facade_m + setback_m, side);
    house.height_m = random.uniform(6.0, 15.0);
    const std::uint64_t seed = random.next();
    TownMesh built;
    add_building(built, house, seed);
    for (const Box& item : draw_clutter(house, mix(seed, 1))) {
      add_box(built, item, Label::kClutter);
    }
    const auto base_m = static_cast<float>(road.at(s_m + 0.5 * front_m).position_m.z());
    for (Eigen::Vector3f& vertex : built.vertices_m) vertex.z() += base_m;
    append(mesh, built);
    s_m += front_m;
    if (random.uniform() < 0.4) s_m += random.uniform(1.5, 5.0);
  }
}

void add_pavement(TownMesh& mesh, const Road& road, const Place& place, const Widths& widths,
                  double side) {
  constexpr double kHigh_m = 0.12;
  const double kerb_m = side * widths.kerb_m(side);
  const double end_m = side * (widths.facade_m(side) + 1.0);
  extrude(mesh, road, {place.from_m, place.to_m},
          {{kerb_m, -0.1}, {kerb_m, kHigh_m}, {end_m, kHigh_m}}, Label::kKerb);
}

}  // namespace

void add_street(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kPoles_m = 18.0;
  const Widths widths = widths_of(road.seed, place);
  for (const double side : {1.0, -1.0}) {
    add_row(mesh, road, place, widths.facade_m(side), side, random);
    add_pavement(mesh, road, place, widths, side);
    const double lateral_m = side * (widths.kerb_m(side) + 0.4);
    for (double s_m = place.from_m + random.uniform(0.0, kPoles_m); s_m < place.to_m;
         s_m += kPoles_m * random.uniform(0.7, 1.3)) {
      const double radius_m = random.uniform(0.06, 0.11);
      add_road_pole(mesh, road, {s_m, lateral_m}, radius_m, random.uniform(4.0, 7.0));
    }
  }
}

void add_street_cars(TownMesh& mesh, const Road& road, const Place& place, Random random) {
  constexpr double kPitch_m = 7.0;
  constexpr double kFromKerb_m = 1.1;
  const Widths widths = widths_of(road.seed, place);
  for (const double side : {1.0, -1.0}) {
    const double lateral_m = side * (widths.kerb_m(side) - kFromKerb_m);
    for (const double s_m : evenly({place.from_m, place.to_m}, kPitch_m)) {
      const bool is_taken = random.uniform() < 0.3;
      const double at_m = s_m + random.uniform(-0.8, 0.8);
      const std::uint64_t seed = random.next();
      if (!is_taken) continue;
      const Eigen::Vector3d base_m = road.on(at_m, lateral_m, road.ground_m(at_m, lateral_m));
      const double yaw_rad = road.at(at_m).heading_rad + (side > 0.0 ? std::numbers::pi : 0.0);
      add_vehicle(mesh, {base_m.head<2>(), yaw_rad}, base_m.z(), seed, Label::kParkedCar);
    }
  }
}

}  // namespace sightline::town
