// The building's own axes: x from its entrance along the first straight, y to the left of it; the
// loop's second straight, its ramp, is at y = 2 kRadius_m. Every storey has the same pillars,
// walls and bays.

#include <algorithm>
#include <array>
#include <numbers>

#include "examples/town/world/furniture.h"
#include "examples/town/world/hard/places.h"

namespace sightline::town {
namespace {

constexpr double kRight_m = -9.5;  // the outer walls
constexpr double kLeft_m = 2.0 * CarPark::kRadius_m + 9.5;
constexpr double kRamp_m = 2.0 * CarPark::kRadius_m;  // its middle
constexpr double kHalfRamp_m = 2.6;
constexpr double kHalfDoor_m = 3.2;  // entrance and exit
constexpr double kSlab_m = 0.25;     // thickness of a floor
constexpr double kParapet_m = 1.1;
constexpr double kBay_m = 2.5;        // width
constexpr double kPillarRow_m = 3.3;  // from a straight's middle

struct Rectangle {
  double x0_m, x1_m, y0_m, y1_m;
};

// The building in the world.
struct ParkBuilding {
  RoadPoint entrance;
  CarPark car_park;

  [[nodiscard]] Eigen::Vector2d flat(double x_m, double y_m) const {
    const Eigen::Vector2d ahead = direction(entrance.heading_rad);
    return entrance.position_m.head<2>() + x_m * ahead + y_m * left_of(ahead);
  }
  [[nodiscard]] double floor_m(int storey) const {
    return entrance.position_m.z() + storey * CarPark::kStorey_m;
  }
  [[nodiscard]] Eigen::Vector3d at(double x_m, double y_m, double z_m) const {
    const Eigen::Vector2d p = flat(x_m, y_m);
    return Eigen::Vector3d(p.x(), p.y(), z_m);
  }
};

ParkBuilding building_of(const Road& road, const Place& place) {
  return {road.at(place.from_m), car_park_of(place)};
}

void add_level(TownMesh& mesh, const ParkBuilding& building, const Rectangle& r, double z_m) {
  add_quad(mesh,
           {building.at(r.x0_m, r.y0_m, z_m), building.at(r.x1_m, r.y0_m, z_m),
            building.at(r.x1_m, r.y1_m, z_m), building.at(r.x0_m, r.y1_m, z_m)},
           Label::kGround);
}

void add_upright(TownMesh& mesh, const ParkBuilding& building, const Rectangle& ends, double z0_m,
                 double z1_m) {
  add_quad(mesh,
           {building.at(ends.x0_m, ends.y0_m, z0_m), building.at(ends.x1_m, ends.y1_m, z0_m),
            building.at(ends.x1_m, ends.y1_m, z1_m), building.at(ends.x0_m, ends.y0_m, z1_m)},
           Label::kFacade);
}

// Floor `storey` and the ceiling below it, with a hole above a ramp that leads to it.
void add_floor(TownMesh& mesh, const ParkBuilding& building, int storey) {
  const double depth_m = building.car_park.depth_m();
  const double z_m = building.floor_m(storey);
  const bool has_hole = storey > 0 && storey <= building.car_park.loops;
  std::vector<Rectangle> pieces = {{0.0, depth_m, kRight_m, kLeft_m}};
  if (has_hole) {
    const double near_m = CarPark::kApproach_m;
    const double far_m = depth_m - CarPark::kApproach_m;
    const Rectangle hole{near_m, far_m, kRamp_m - kHalfRamp_m, kRamp_m + kHalfRamp_m};
    pieces = {{0.0, depth_m, kRight_m, hole.y0_m},
              {0.0, depth_m, hole.y1_m, kLeft_m},
              {0.0, hole.x0_m, hole.y0_m, hole.y1_m},
              {hole.x1_m, depth_m, hole.y0_m, hole.y1_m}};
    for (const double y_m : {hole.y0_m, hole.y1_m}) {
      add_upright(mesh, building, {hole.x0_m, hole.x1_m, y_m, y_m}, z_m - kSlab_m, z_m);
    }
  }
  for (const Rectangle& piece : pieces) {
    add_level(mesh, building, piece, z_m);
    if (storey > 0) add_level(mesh, building, piece, z_m - kSlab_m);
  }
}

// A front at x = 0 or at the far end; `has_door`: with a gap around the first straight.
void add_front_wall(TownMesh& mesh, const ParkBuilding& building, double x_m, int storey,
                    bool has_door) {
  const double z_m = building.floor_m(storey);
  const double right_m = has_door ? -kHalfDoor_m : 0.0;
  const double left_m = has_door ? kHalfDoor_m : 0.0;
  add_upright(mesh, building, {x_m, x_m, kRight_m, right_m}, z_m - kSlab_m, z_m + kParapet_m);
  add_upright(mesh, building, {x_m, x_m, left_m, kLeft_m}, z_m - kSlab_m, z_m + kParapet_m);
}

void add_walls(TownMesh& mesh, const ParkBuilding& building, int storey) {
  const double depth_m = building.car_park.depth_m();
  const double z_m = building.floor_m(storey);
  add_front_wall(mesh, building, 0.0, storey, storey == 0);
  add_front_wall(mesh, building, depth_m, storey, storey == building.car_park.loops);
  for (const double y_m : {kRight_m, kLeft_m}) {
    add_upright(mesh, building, {0.0, depth_m, y_m, y_m}, z_m - kSlab_m, z_m + kParapet_m);
  }
}

void add_column(TownMesh& mesh, const ParkBuilding& building, const Rectangle& r, int storey,
                Label label) {
  const double z_m = building.floor_m(storey);
  add_box(mesh,
          {building.flat(0.5 * (r.x0_m + r.x1_m), 0.5 * (r.y0_m + r.y1_m)),
           building.entrance.heading_rad, r.x1_m - r.x0_m, r.y1_m - r.y0_m, z_m,
           z_m + CarPark::kStorey_m - kSlab_m},
          label);
}

// Pillars of 0.4 m beside both straights and between them, and a staircase.
void add_pillars(TownMesh& mesh, const ParkBuilding& building, int storey) {
  constexpr double kHalf_m = 0.2;
  constexpr double kPitch_m = 3.0 * kBay_m;
  const double depth_m = building.car_park.depth_m();
  const auto pillar = [&](double x_m, double y_m) {
    add_column(mesh, building, {x_m - kHalf_m, x_m + kHalf_m, y_m - kHalf_m, y_m + kHalf_m}, storey,
               Label::kFacade);
  };
  for (double x_m = 4.0; x_m < depth_m - 3.0; x_m += kPitch_m) {
    pillar(x_m, -kPillarRow_m);
    pillar(x_m, kRamp_m + kPillarRow_m);
    const bool is_between = x_m > CarPark::kApproach_m && x_m < depth_m - CarPark::kApproach_m;
    if (is_between) pillar(x_m, CarPark::kRadius_m);
  }
  add_column(mesh, building, {0.6, 3.6, kLeft_m - 4.2, kLeft_m - 0.2}, storey, Label::kFacade);
}

// The road surface of a ramp, with low walls beside it.
void add_ramp(TownMesh& mesh, const Road& road, const Place& place, const CarPark& car_park,
              int i) {
  const double from_m = place.from_m + car_park.ramp_from_m(i);
  const Stretch ramp{from_m, from_m + car_park.straight_m};
  extrude(mesh, road, ramp, {{-kHalfRamp_m, 0.0}, {kHalfRamp_m, 0.0}}, Label::kGround);
  for (const double side_m : {-kHalfRamp_m, kHalfRamp_m}) {
    extrude(mesh, road, ramp, {{side_m, -kSlab_m}, {side_m, 0.8}}, Label::kFacade);
  }
}

// Where cars may stand on a storey: x, y and the direction of their front, quarters of a turn.
struct Bay {
  double x_m = 0.0;
  double y_m = 0.0;
  double quarters = 1.0;
};
std::vector<Bay> bays_of(const CarPark& car_park) {
  constexpr double kBehindPillars_m = 2.7;
  const double depth_m = car_park.depth_m();
  std::vector<Bay> bays;
  for (double x_m = 4.0 + 0.5 * kBay_m; x_m < depth_m - 3.0; x_m += kBay_m) {
    bays.push_back({x_m, -kPillarRow_m - kBehindPillars_m, -1.0});
    bays.push_back({x_m, kRamp_m + kPillarRow_m + kBehindPillars_m, 1.0});
    const bool is_between =
        x_m > CarPark::kApproach_m + 1.0 && x_m < depth_m - CarPark::kApproach_m - 1.0;
    if (is_between) bays.push_back({x_m, CarPark::kRadius_m, 1.0});
  }
  return bays;
}

struct ParkedCar {
  bool is_there = false;
  double off_m = 0.0;
  double turned_rad = 0.0;
  std::uint64_t seed = 0;
};
ParkedCar draw_car(Random random) {
  constexpr double kTaken = 0.6;
  ParkedCar car;
  car.is_there = random.uniform() < kTaken;
  car.off_m = random.uniform(-0.25, 0.25);
  car.turned_rad = random.uniform(-0.04, 0.04);
  car.seed = random.next();
  return car;
}

}  // namespace

void add_car_park(TownMesh& mesh, const Road& road, const Place& place) {
  const ParkBuilding building = building_of(road, place);
  for (int storey = 0; storey <= building.car_park.loops; ++storey) {
    add_floor(mesh, building, storey);
    add_walls(mesh, building, storey);
    add_pillars(mesh, building, storey);
  }
  add_floor(mesh, building, building.car_park.loops + 1);
  for (int i = 0; i < building.car_park.loops; ++i) {
    add_ramp(mesh, road, place, building.car_park, i);
  }
}

void add_car_park_cars(TownMesh& mesh, const Road& road, const Place& place,
                       const DriveSeed& seed) {
  const ParkBuilding building = building_of(road, place);
  const std::vector<Bay> bays = bays_of(building.car_park);
  std::uint64_t key = 0;
  for (int storey = 0; storey <= building.car_park.loops; ++storey) {
    for (const Bay& bay : bays) {
      const std::uint64_t bay_seed = mix(seed.seed, ++key);
      Random change(mix(bay_seed, seed.drive));
      const bool is_as_mapped = seed.drive == 0 || change.uniform() < 0.5;
      const ParkedCar car =
          draw_car(is_as_mapped ? Random(mix(bay_seed, 0)) : Random(change.next()));
      if (!car.is_there) continue;
      const double yaw_rad =
          building.entrance.heading_rad + 0.5 * std::numbers::pi * bay.quarters + car.turned_rad;
      add_vehicle(mesh, {building.flat(bay.x_m, bay.y_m + car.off_m), yaw_rad},
                  building.floor_m(storey), car.seed, Label::kParkedCar);
    }
  }
}

}  // namespace sightline::town
