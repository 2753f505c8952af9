#pragma once

#include <vector>

#include "tests/fuzz/seed.h"

namespace sightline {

// Bags, captures, poses, lanes, Apollo's maps, configurations and rules of the gate.
void add_foreign_seeds(std::vector<Seed>& seeds);

}  // namespace sightline
