#pragma once

#include <vector>

namespace sightline {

// The ranges that a map compares unless its configuration names others: those of the paper's
// figures, m, ascending.
inline std::vector<double> default_ranges_m() {
  return {10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0};
}

}  // namespace sightline
