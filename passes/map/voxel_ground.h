#pragma once

#include <cstdint>

#include "passes/map/seen_voxels.h"

namespace sightline {

// Columns of the plane, 3 x 3 voxels each, as one number, so that the neighbour of a column is a
// sum away: column_of(key) + column_number(1, 0).
std::int64_t column_number(std::int64_t x, std::int64_t y);
std::int64_t column_of(const CellKey& key);

// How many voxels away the ground below one is looked for.
std::int32_t reach_of_ground_voxels();

// Fills is_ground, is_level and above_ground_m. Ground is what lies within a hand's breadth of the
// lowest return of its surroundings, and a level surface up to 0.5 m above it on which nothing
// stands; what lies beneath the level that the surroundings have in common is a mirror image in wet
// or polished ground and does not count.
void mark_ground(SeenVoxels& seen);

}  // namespace sightline
