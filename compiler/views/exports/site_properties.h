#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "formats/map/compiled_map.h"

namespace sightline {

// What a GIS gets of a site: its number, run and place along it, and for each limit
// ("..._within_0.1_m") range, probability, error, flags and, where a map has them, the look; then
// the map's columns. The same names in the same order at every site of a map.
using SiteProperty = std::variant<bool, std::int64_t, double, std::string>;
std::vector<std::pair<std::string, SiteProperty>> site_properties(const CompiledMap& map,
                                                                  std::size_t site);

// "range_m_within_0.1_m"
std::string range_property(const CompiledMap& map, std::size_t limit);

}  // namespace sightline
