#pragma once

#include <vector>

#include "tests/fuzz/seed.h"

namespace sightline {

// Captures of Ouster's and Hesai's sensors with what lies beside them.
void add_lidar_seeds(std::vector<Seed>& seeds);

}  // namespace sightline
