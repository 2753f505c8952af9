#pragma once

#include "examples/town/world/hard/road.h"
#include "examples/town/world/town.h"

namespace sightline::town {

// Shortest lengths of hard worlds, m; one that is not bare has kEnd_m of town at both ends.
inline constexpr double kShortestHard_m = 120.0;
inline constexpr double kShortestBare_m = 40.0;

// Gives a town of a hard world its line, its places and what never changes there. What the places
// are goes on for 110 m beyond both ends of the line.
void build_hard_world(Town& town);

// The road of a hard world; refers to the town.
Road road_of(const Town& town);

// The parked cars of one drive: those of a street are others on each drive, and half of those of a
// car park are.
void add_hard_cars(TownMesh& mesh, const Town& town, std::uint64_t drive);

}  // namespace sightline::town
