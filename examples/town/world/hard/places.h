#pragma once

#include <cstdint>

#include "examples/town/world/hard/road.h"

// What is at each kind of place, beside the ground. Everything that has equal spacing has it
// exactly, in arc length.

namespace sightline::town {

// Of what is there on one drive alone; drive 0 maps.
struct DriveSeed {
  std::uint64_t seed = 0;
  std::uint64_t drive = 0;
};

// Houses along both sides, with poles and clutter.
void add_street(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_tunnel(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_motorway(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_noise_barrier(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_bridge(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_field(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_forest(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_plaza(TownMesh& mesh, const Road& road, const Place& place, Random random);
void add_hills(TownMesh& mesh, const Road& road, const Place& place, Random random);
// Floors, ramps, pillars and walls; the cars that are there on one drive.
void add_car_park(TownMesh& mesh, const Road& road, const Place& place);
void add_car_park_cars(TownMesh& mesh, const Road& road, const Place& place, const DriveSeed& seed);
// Parked cars of a street on one drive.
void add_street_cars(TownMesh& mesh, const Road& road, const Place& place, Random random);

// Between its walls alone in a tunnel; 15 m below a bridge; none in a car park.
void add_place_ground(TownMesh& mesh, const Road& road, const Place& place);

// How a tunnel's tube and a bridge's deck are, by the world's seed and the place.
struct Tube {
  double left_m = 6.0;    // lateral of the left wall
  double right_m = 4.5;   // -lateral of the right wall
  double pitch_m = 12.0;  // of the lamps
};
Tube tube_of(std::uint64_t seed, const Place& place);
inline constexpr double kDeckLeft_m = 8.0;  // lateral of a bridge's left edge
inline constexpr double kDeckRight_m = 5.5;

}  // namespace sightline::town
