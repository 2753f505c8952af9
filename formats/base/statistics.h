#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace sightline {

// Of values that are not empty, summed in a fixed order.
double mean_of(std::span<const double> values);

// The value below which `share` (0..1) of the values lie, by linear interpolation between order
// statistics. `sorted` ascends and is not empty.
double quantile_of_sorted(std::span<const double> sorted, double share);

// Positions of `most` of so many things, or of all where they are fewer: each in the middle of one
// of equal stretches; ascending.
inline std::vector<std::size_t> evenly(std::size_t size, std::size_t most) {
  const std::size_t count = std::min(size, most);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back((2 * i + 1) * size / (2 * count));
  return chosen;
}

}  // namespace sightline
