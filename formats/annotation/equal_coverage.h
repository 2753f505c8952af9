#pragma once

#include <span>

namespace sightline {

// What a rule achieves: the share of places that it serves, and what it costs there (work or time).
struct CoveredCost {
  double coverage = 0.0;
  double cost = 0.0;
};

// What it costs to serve as many places.
struct CostAtCoverage {
  double coverage = 0.0;  // that was asked for, or, where it is not reached, the most that there is
  double cost = 0.0;
  bool is_reached = false;
};

// The cost of `coverage` with answers that are the same everywhere: linear between neighbours of
// those that no other answer beats, the cheapest of all below them, and above them the one of most
// coverage, with its own. A mixture of two neighbours, at random places, costs as much.
// At least one answer.
CostAtCoverage cost_at_coverage(std::span<const CoveredCost> answers, double coverage);

}  // namespace sightline
