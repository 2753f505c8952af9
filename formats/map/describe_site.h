#pragma once

#include <cstddef>
#include <string>

#include "formats/map/compiled_map.h"

namespace sightline {

// For people: why one site looks as far as it does. Predicted error and probability at every range;
// for each limit the range that the rule of the map names here, what neighbours, extrapolation or a
// lack of good ranges made of it, and the nearest site along the route that does with less; where
// the map holds factors, those far from the route's median (robust z: 0.6745 (x - median) / median
// absolute deviation, at least 2) and the weakest direction. Errors: bad-argument where there is no
// such site.
Result<std::string> describe_site(const CompiledMap& map, std::size_t site);

}  // namespace sightline
