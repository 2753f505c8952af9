#pragma once

#include <Eigen/Geometry>

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// The map with its NDs over a box of the plane, maybe some around, and no other; in their order.
// Costs what lies there, however large the map is. The box is finite.
NdtMap nds_over(const NdtMap& map, const Eigen::AlignedBox2d& box_m);

}  // namespace sightline
