#pragma once

#include "examples/town/world/hard/road.h"

namespace sightline::town {

// Shortest lengths of hard worlds, m; one that is not bare has kEnd_m of town at both ends.
inline constexpr double kShortestHard_m = 120.0;
inline constexpr double kShortestBare_m = 40.0;

// What never changes in a hard world. What its places are goes on for 110 m beyond both ends of the
// line.
TownMesh hard_mesh(const Road& road);

// The parked cars of one drive: those of a street are others on each drive, and half of those of a
// car park are.
void add_hard_cars(TownMesh& mesh, const Road& road, std::uint64_t drive);

}  // namespace sightline::town
