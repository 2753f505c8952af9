#include "tests/compiler/gate/route_map.h"

#include "tests/formats/map/random_map.h"

namespace sightline {

CompiledMap route_map(int site_count) {
  CompiledMap map = random_map({.seed = 1, .site_count = site_count, .run_count = 1});
  map.ndt.frame.origin_world_m = {640.0, -64.0, 0.0};
  map.sites.frame = map.ndt.frame;
  map.factors.factors = {"virtual_points"};
  map.factors.values.clear();
  map.model.mean_r_squared = 0.375;
  for (auto& promise : map.ranges.promises) {
    promise.is_earned = true;
    promise.scope = PromiseScope::kNextDrive;
  }
  map.measurement.measured_site_count = static_cast<std::uint32_t>(site_count);
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    map.sites.sites[site].p_map_m = {static_cast<double>(site), 0.0, 1.8};
    for (const double points : {100.0, 200.0, 500.0}) map.factors.values.push_back(points);
    set_site(map, site, {});
  }
  sum_up(map);
  return map;
}

void set_site(CompiledMap& map, std::size_t site, const SiteNumbers& numbers) {
  const std::size_t ranges = map.ranges.looks.size();
  for (std::size_t range = 0; range < ranges; ++range) {
    map.predicted.mean_m[site * ranges + range] = numbers.mean_m;
    double* within = &map.predicted.within_probability[(site * ranges + range) * 2];
    within[0] = numbers.probability;
    within[1] = numbers.probability + 0.8 * (1.0 - numbers.probability);
  }
  for (std::size_t limit = 0; limit < 2; ++limit) {
    map.ranges.range_index[site * 2 + limit] = numbers.range_index;
    map.ranges.flags[site * 2 + limit] = numbers.flags;
  }
}

void sum_up(CompiledMap& map) {
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  for (LimitQuality& quality : map.quality) quality.measured_coverage = 1.0;
}

}  // namespace sightline
