#include "formats/base/statistics.h"

#include <algorithm>
#include <cstddef>

#include "formats/base/check.h"
#include "formats/base/parallel.h"

namespace sightline {

double mean_of(std::span<const double> values) {
  SIGHTLINE_CHECK(!values.empty());
  return ordered_sum(values) / static_cast<double>(values.size());
}

double quantile_of_sorted(std::span<const double> sorted, double share) {
  SIGHTLINE_CHECK(!sorted.empty());
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace sightline
