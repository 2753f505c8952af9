#include "passes/factors/paper/r_average.h"

namespace sightline {

std::vector<double> r_average(const Vicinity& vicinity) {
  std::vector<double> average_m;
  double sum_m = 0.0;
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      sum_m += vicinity.distance_m[i];
    }
    const std::size_t count = vicinity.end[range];
    average_m.push_back(count == 0 ? vicinity.ranges_m[range] : sum_m / static_cast<double>(count));
  }
  return average_m;
}

}  // namespace sightline
