#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/integrity/closed_loop.h"

namespace sightline {

// What became of poses that were pulled off sideways, where truth constrains that direction.
struct FaultCounts {
  std::size_t faults = 0;
  std::size_t found = 0;    // within 25 cm in 10 scans, in the directions that are constrained
  std::size_t alarmed = 0;  // of the others, by the monitor in 10 scans
};

// By kind of place and cm.
using FaultTable = std::map<std::pair<std::string, int>, FaultCounts>;

// At every 30th scan the pose is pulled off by 0.5, 1, 2 and 5 m, to the left and right in turn,
// and tracked from there for 10 scans: each start is the last returned pose with the true motion,
// and the covariance that of a tracking start.
void add_faults(WorldLocalizer& localizer, const TrueDrive& drive, FaultTable& table);
void print_faults(const FaultTable& table);

}  // namespace sightline
