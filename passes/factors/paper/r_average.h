#pragma once

#include <vector>

#include "passes/factors/paper/vicinity.h"

namespace sightline {

// Mean distance of the NDs within each range, m (paper, Eq. 4, which lost its 1/m); the range
// itself where there is none.
std::vector<double> r_average(const Vicinity& vicinity);

}  // namespace sightline
