#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "passes/map/places/free_ground.h"

namespace sightline {

// The way that a vehicle looks at a free place, of unit length: the first of 16, evenly over half a
// turn from +x on, along which free ground goes on farthest, ahead and behind together, each for
// 20 m at most.
Eigen::Vector2d free_heading(const FreeGround& free, std::uint32_t place);

}  // namespace sightline
