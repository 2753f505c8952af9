#pragma once

#include <array>
#include <span>
#include <vector>

#include "passes/factors/paper/vicinity.h"

namespace sightline {

// NDs of class 1, 2 and 3 (element 0, 1, 2).
using ByDimension = std::array<double, 3>;

// d1_count, d2_count, d3_count of each range (paper, section IV-B; classes by Eq. 1).
// dimension_class_of[i] is the class of nds[i], as dimension_class() gives it.
std::vector<ByDimension> dimension_counts(const Vicinity& vicinity,
                                          std::span<const int> dimension_class_of);

// Share of each class among all; all 0 where there is none.
ByDimension dimension_ratios(const ByDimension& counts);

}  // namespace sightline
