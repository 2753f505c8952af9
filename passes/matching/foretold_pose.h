#pragma once

#include "formats/geometry.h"

namespace sightline {

// Where a vehicle will be that moves on evenly. `motion` is its last one, in its own frame
// (T_before_last); `factor` is the time until then over the time which that took.
Pose foretold_pose(const Pose& T_map_last, const Pose& motion, double factor = 1.0);

}  // namespace sightline
