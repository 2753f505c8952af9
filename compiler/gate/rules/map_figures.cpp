#include "compiler/gate/rules/map_figures.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

std::optional<std::size_t> virtual_points(const CompiledMap& map) {
  const auto found = std::ranges::find(map.factors.factors, "virtual_points");
  if (found == map.factors.factors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - map.factors.factors.begin());
}

}  // namespace

std::vector<double> chosen_probabilities(const CompiledMap& map, std::size_t limit) {
  std::vector<double> values;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    values.push_back(map.predicted.probability(site, map.ranges.range(site, limit), limit));
  }
  return values;
}

std::vector<double> chosen_ranges_m(const CompiledMap& map, std::size_t limit) {
  std::vector<double> values;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    values.push_back(map.ranges.range_m(site, limit));
  }
  return values;
}

std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit) {
  std::vector<bool> is_unmet;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    is_unmet.push_back((map.ranges.flags_of(site, limit) & kUnmet) != 0);
  }
  return is_unmet;
}

double p95_range_m(const CompiledMap& map, std::size_t limit) {
  std::vector<double> ranges_m = chosen_ranges_m(map, limit);
  std::ranges::sort(ranges_m);
  const auto needed =
      static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(ranges_m.size())));
  return ranges_m[needed - 1];
}

bool has_virtual_points(const CompiledMap& map) { return virtual_points(map).has_value(); }

std::optional<double> expected_work(const CompiledMap& map, std::size_t limit) {
  const std::optional<std::size_t> column = virtual_points(map);
  if (!column) return std::nullopt;
  std::vector<double> at_chosen;
  std::vector<double> at_longest;
  const std::size_t longest = map.ranges.looks.size() - 1;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    at_chosen.push_back(map.factors.at(site, map.ranges.range(site, limit), *column));
    at_longest.push_back(map.factors.at(site, longest, *column));
  }
  const double whole = ordered_sum(at_longest);
  if (!(whole > 0.0)) return std::nullopt;
  return ordered_sum(at_chosen) / whole;
}

}  // namespace sightline
