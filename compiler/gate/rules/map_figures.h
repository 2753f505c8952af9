#pragma once

#include <optional>
#include <vector>

#include "formats/map/compiled_map.h"

// Figures of a map that its manifest does not hold and the rules of the gate ask for.

namespace sightline {

// P(error <= limit) at the chosen range, by site.
std::vector<double> chosen_probabilities(const CompiledMap& map, std::size_t limit);
// Chosen range, by site, m.
std::vector<double> chosen_ranges_m(const CompiledMap& map, std::size_t limit);
std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit);

// The least chosen range that at least 95 % of the sites do not exceed.
double p95_range_m(const CompiledMap& map, std::size_t limit);

bool has_virtual_points(const CompiledMap& map);
// Sum over sites of the factor virtual_points at the chosen range over that at the longest; none
// where the map holds no such factor.
std::optional<double> expected_work(const CompiledMap& map, std::size_t limit);

}  // namespace sightline
