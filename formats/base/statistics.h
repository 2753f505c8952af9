#pragma once

#include <span>

namespace sightline {

// Of values that are not empty, summed in a fixed order.
double mean_of(std::span<const double> values);

// The value below which `share` (0..1) of the values lie, by linear interpolation between order
// statistics. `sorted` ascends and is not empty.
double quantile_of_sorted(std::span<const double> sorted, double share);

}  // namespace sightline
