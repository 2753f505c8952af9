#pragma once

#include <span>
#include <vector>

#include "formats/surroundings/surface.h"

namespace sightline {

// Level patches for unseen ground between the lines of a scan, where rays would go on below it.
// Straight from ground on one side to ground on the other, in the direction in which that is
// nearest, where both are at heights that one street may have; level for five columns of two cells
// where ground lies on one side alone, as at the foot of a wall. Only is_ground() patches count.
std::vector<SurfacePatch> ground_between(std::span<const SurfacePatch> patches, double cell_m);

// Patches farther away, along either axis, have no part in what is between.
inline constexpr double kReachOfGround_cells = 34.0;

// Whether a patch is level, and no shard of something else.
bool is_ground(const SurfacePatch& patch);

// True of such a patch of a surface: no other is exactly two cells wide.
inline bool is_ground_between(const SurfacePatch& patch, const Surface& surface) {
  return patch.half_side_m == surface.cell_m;
}

}  // namespace sightline
