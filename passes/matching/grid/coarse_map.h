#pragma once

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// The map with cells `factor` times as long, each pooled from the NDs in it: count, mean and
// covariance are those of all their points. Points of cells that had too few for an ND stay lost.
// factor >= 1; where the tiles cannot hold the longer cells they become larger.
NdtMap coarse_map(const NdtMap& map, int factor);

}  // namespace sightline
