#pragma once

#include <vector>

#include "tests/fuzz/seed.h"

namespace sightline {

// MCAP files without checksums, so that what chunks hold can be mutated, and .db3.
void add_ros2_seeds(std::vector<Seed>& seeds);

}  // namespace sightline
