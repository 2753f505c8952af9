#pragma once

#include "formats/map/compiled_map.h"

namespace sightline {

// A straight road along x in the map, a site a metre: ranges 10, 20 and 50 m, limits 0.1 and
// 0.25 m, all sites alike: 10 m are chosen, at which 5 cm of error are expected and 0.95 and 0.99
// are the probabilities. The factor virtual_points is 100, 200 and 500. The frame's origin is at
// (640, -64, 0) in the world.
CompiledMap route_map(int site_count);

// From here on such numbers at one site, limits being those of the map.
struct SiteNumbers {
  std::uint8_t range_index = 0;  // for both limits
  double mean_m = 0.05;          // at every range
  double probability = 0.95;     // for the first limit at every range
  std::uint8_t flags = 0;
};
void set_site(CompiledMap& map, std::size_t site, const SiteNumbers& numbers);

// After set_site: what the manifest says of the limits.
void sum_up(CompiledMap& map);

}  // namespace sightline
