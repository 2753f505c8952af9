#pragma once

#include <vector>

#include "passes/factors/paper/vicinity.h"

namespace sightline {

// Number of NDs within each range (paper, section IV-A).
std::vector<double> feature_count(const Vicinity& vicinity);

}  // namespace sightline
