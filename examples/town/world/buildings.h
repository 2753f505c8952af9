#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/world/mesh.h"
#include "examples/town/world/plan.h"

namespace sightline::town {

// A building stands on a rectangle; its front looks along -y of the rectangle's own frame.
struct Building {
  Footprint footprint;
  double height_m = 10.0;
  StreetKind kind = StreetKind::kSide;  // of the street that its front faces
  bool is_background = false;           // behind the rows along the streets; without detail
  bool is_gone = false;                 // an empty plot
};

// Rows along every street, and others behind them. No building stands on a street or in another.
std::vector<Building> place_buildings(std::uint64_t seed, const TownPlan& plan);

// Walls, roof, and what never changes of a front: windows, doors, pilasters.
void add_building(TownMesh& mesh, const Building& building, std::uint64_t seed);

// Balconies, ledges, signs and the like on one front, some of which come and go between drives.
std::vector<Box> draw_clutter(const Building& building, std::uint64_t seed);

// A piece of clutter drawn anew: what stands there instead, or besides.
Box draw_clutter_item(const Building& building, std::uint64_t seed);

}  // namespace sightline::town
