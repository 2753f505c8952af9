#pragma once

#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// What rays can hit where of a place nothing but its NDs is known, as in a map file: a patch for
// each ND, flat at right angles to its shortest axis, solid as far as points that lie evenly would
// reach with the ND's variances (sqrt(3) sigma along each of the other axes). Of NDs of class 3,
// which are leaves and clutter, every other square is open.
Surface surface_of_nds(const NdtMap& map);

}  // namespace sightline
