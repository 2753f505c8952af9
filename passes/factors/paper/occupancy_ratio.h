#pragma once

#include <span>
#include <vector>

namespace sightline {

// Share of a depth image's cells whose first hit lies within each range (paper, Eq. 2). Every cell
// in view weighs the same; +inf is no hit, NaN out of view. 0 where no cell is in view.
std::vector<double> occupancy_ratio(std::span<const float> distance_m,
                                    const std::vector<double>& ranges_m);

}  // namespace sightline
