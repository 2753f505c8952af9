#include "passes/factors/paper/dimensions.h"

namespace sightline {

std::vector<ByDimension> dimension_counts(const Vicinity& vicinity,
                                          std::span<const int> dimension_class_of) {
  std::vector<ByDimension> by_range;
  ByDimension counts{};
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      counts[static_cast<std::size_t>(dimension_class_of[vicinity.nd_index[i]] - 1)] += 1.0;
    }
    by_range.push_back(counts);
  }
  return by_range;
}

ByDimension dimension_ratios(const ByDimension& counts) {
  const double total = counts[0] + counts[1] + counts[2];
  if (total == 0.0) return {};
  return {counts[0] / total, counts[1] / total, counts[2] / total};
}

}  // namespace sightline
