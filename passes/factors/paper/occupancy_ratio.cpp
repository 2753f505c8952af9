#include "passes/factors/paper/occupancy_ratio.h"

#include <algorithm>
#include <cmath>

namespace sightline {

std::vector<double> occupancy_ratio(std::span<const float> distance_m,
                                    const std::vector<double>& ranges_m) {
  // Cells by the first range that reaches them, then running sums over ranges.
  std::vector<std::size_t> first_reached(ranges_m.size() + 1, 0);
  std::size_t in_view = 0;
  for (const float distance : distance_m) {
    if (std::isnan(distance)) continue;
    ++in_view;
    const auto range =
        std::lower_bound(ranges_m.begin(), ranges_m.end(), static_cast<double>(distance));
    ++first_reached[static_cast<std::size_t>(range - ranges_m.begin())];
  }
  std::vector<double> ratio;
  const double cells = std::max(1.0, static_cast<double>(in_view));
  std::size_t occupied = 0;
  for (std::size_t range = 0; range < ranges_m.size(); ++range) {
    occupied += first_reached[range];
    ratio.push_back(static_cast<double>(occupied) / cells);
  }
  return ratio;
}

}  // namespace sightline
