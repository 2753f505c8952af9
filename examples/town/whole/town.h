#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/world/buildings.h"
#include "examples/town/world/change.h"
#include "examples/town/world/furniture.h"
#include "examples/town/world/hard/place.h"
#include "examples/town/world/hard/road.h"
#include "examples/town/world/mesh.h"
#include "examples/town/world/plan.h"
#include "formats/base/result.h"

// A town made from a seed, hard in the ways in which real towns are: wide streets, open places,
// smooth walls and repeating facades among easy ones.

namespace sightline::town {

struct TownOptions {
  std::uint64_t seed = 1;
  double length_m = 600.0;         // of the driven line, 20 to 20000
  bool is_round = false;           // the line closes around a block; at least 200 m then
  TownChange change = {};          // what happened to a stretch of it meanwhile
  std::vector<Board> boards = {};  // that were put up, in town coordinates
  // A hard world instead, which is neither round nor changed and has no boards.
  WorldKind world = {};
  bool is_bare = false;  // it has no town at both ends
};

// What is true of the town for every drive through it.
struct Town {
  TownOptions options;
  TownPlan plan;
  TownMesh permanent;  // ground, pavements, buildings, trees, poles, boards
  std::vector<Building> buildings;
  std::vector<Place> places;  // of a hard world, whose plan has no streets

  [[nodiscard]] bool is_hard() const { return options.world.is_hard; }
  // Of a hard world; refers to this.
  [[nodiscard]] Road road() const { return {options.seed, plan.line, places}; }
};

// Error: bad-argument.
Result<Town> make_town(const TownOptions& options);

// Everything that stands still while drive `drive` takes place: the permanent mesh, and that
// drive's parked cars and clutter. Drive 0 maps; in every other 10 % of the clutter of drive 0 is
// gone and as much is new.
TownMesh standing_mesh(const Town& town, std::uint64_t drive);

}  // namespace sightline::town
