#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/map/compiled_map.h"

namespace sightline {

// Where the middle of a route lies, and how far from it half of its sites are: median and median
// absolute deviation over all sites, [range][factor].
struct RouteFactors {
  std::vector<double> median;
  std::vector<double> deviation;
};
RouteFactors route_factors(const FactorTable& factors);

// How many deviations a value is off the median, a normal distribution's sigma being the unit;
// 0 where half of the route has one and the same value.
double robust_z(double value, double median, double deviation);

// For people: why one site looks as far as it does. Predicted error and probability at every range;
// for each limit the range that the rule of the map names here, what neighbours, extrapolation or a
// lack of good ranges made of it, and the nearest site along the route with a shorter range; where
// the map holds factors, those far from the route's median (robust z: 0.6745 (x - median) / median
// absolute deviation, at least 2) and the weakest direction. Errors: bad-argument where there is no
// such site.
Result<std::string> describe_site(const CompiledMap& map, std::size_t site);
// The same of many sites, with route_factors(map.factors) worked out once.
Result<std::string> describe_site(const CompiledMap& map, const RouteFactors& route,
                                  std::size_t site);

}  // namespace sightline
