#include "compiler/gate/rules/map_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

auto virtual_points(const CompiledMap& map) {
  return std::ranges::find(map.factors.factors, "virtual_points");
}

}  // namespace

double share_of_sites(const CompiledMap& map, std::uint32_t count) {
  return static_cast<double>(count) / static_cast<double>(map.ranges.site_count);
}

double p95_range_m(const CompiledMap& map, std::size_t limit) {
  std::vector<double> ranges_m;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    ranges_m.push_back(map.ranges.range_m(site, limit));
  }
  std::ranges::sort(ranges_m);
  const auto needed =
      static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(ranges_m.size())));
  return ranges_m[needed - 1];
}

bool has_virtual_points(const CompiledMap& map) {
  return virtual_points(map) != map.factors.factors.end();
}

double expected_work(const CompiledMap& map, std::size_t limit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!has_virtual_points(map)) return kNone;
  const auto column = static_cast<std::size_t>(virtual_points(map) - map.factors.factors.begin());
  std::vector<double> at_chosen;
  std::vector<double> at_longest;
  const std::size_t longest = map.ranges.looks.size() - 1;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    at_chosen.push_back(map.factors.at(site, map.ranges.range(site, limit), column));
    at_longest.push_back(map.factors.at(site, longest, column));
  }
  const double whole = ordered_sum(at_longest);
  return whole > 0.0 ? ordered_sum(at_chosen) / whole : kNone;
}

double chosen_probability(const CompiledMap& map, std::size_t site, std::size_t limit) {
  return map.predicted.probability(site, map.ranges.range(site, limit), limit);
}

std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit) {
  std::vector<bool> is_unmet;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    is_unmet.push_back((map.ranges.flags_of(site, limit) & kUnmet) != 0);
  }
  return is_unmet;
}

}  // namespace sightline
