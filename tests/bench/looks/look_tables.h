#pragma once

#include <span>
#include <vector>

#include "tests/bench/looks/measure_looks.h"

namespace sightline {

// What was measured: [town][rule][place]. The first rule is the reference that all are compared
// with.
using TownsFigures = std::vector<std::vector<RuleFigures>>;

// At each place the cheapest look, by its work there, that is within the limit, else the most
// accurate: figures as of one rule. It knows the errors; no rule does. Its time is that of the
// looks it took, where they were timed (one run's time would choose by noise).
RuleFigures oracle_of_looks(std::span<const MeasuredRule> rules,
                            std::span<const RuleFigures> figures, double limit_m);

// One row for each rule and for the oracles of 10 and 25 cm: coverage (share of places whose mean
// error over the starts is within the limit: mean over the towns, worst town), median error,
// points, evaluations, and work, time and cut over the reference's.
void print_looks(std::span<const MeasuredRule> rules, const TownsFigures& figures);

// Beside the time of each what the best static look of equal coverage takes (cost_at_coverage()):
// of those without a map, and of all. Where none covers as much, the most accurate, with its
// coverage. What is dearer than a look without a map is called so.
void print_equal_coverage(std::span<const MeasuredRule> rules, const TownsFigures& figures);

}  // namespace sightline
