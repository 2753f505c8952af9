#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "examples/town/world/buildings.h"
#include "examples/town/world/furniture.h"
#include "examples/town/world/plan.h"

// What happens to a stretch of a town between two recordings of it; the rest stays as it was.

namespace sightline::town {

struct TownChange {
  double from_m = 0.0;  // arc length of the driven line; no change where to_m is not greater
  double to_m = 0.0;
  bool rebuilds = true;       // other heights and fronts, some houses set back
  bool removes_wall = true;   // the house whose front is longest is gone
  int added_cars = 10;        // parked along both sides
  double noise_factor = 1.5;  // on the range noise of scans taken there

  [[nodiscard]] bool is_any() const { return to_m > from_m; }
  [[nodiscard]] bool is_at(double s_m) const { return s_m >= from_m && s_m < to_m; }
};

// Houses whose nearest place of the driven line is in the stretch; those behind the rows stay.
// Tells which have new fronts.
std::set<std::size_t> change_buildings(const TownChange& change, std::uint64_t seed,
                                       const TownPlan& plan, std::vector<Building>& buildings);

// Where the added cars stand, evenly along the stretch, on its left and right in turn.
std::vector<Pose2d> added_cars(const TownChange& change, std::uint64_t seed, const TownPlan& plan);

}  // namespace sightline::town
