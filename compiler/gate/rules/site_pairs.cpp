#include "compiler/gate/rules/site_pairs.h"

#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

Eigen::Vector3d p_world_m(const CompiledMap& map, std::size_t site) {
  return map.sites.sites[site].p_map_m + map.sites.frame.origin_world_m;
}

std::vector<std::optional<std::uint32_t>> nearest_of(const CompiledMap& from,
                                                     const CompiledMap& to) {
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t site = 0; site < to.sites.sites.size(); ++site) {
    places_m.push_back(p_world_m(to, site));
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::uint32_t>> found(from.sites.sites.size());
  for (std::size_t site = 0; site < found.size(); ++site) {
    const std::optional<NearPoint> nearest = grid.nearest(p_world_m(from, site), to.reach_m);
    if (nearest) found[site] = static_cast<std::uint32_t>(nearest->index);
  }
  return found;
}

}  // namespace

SitePairs pair_sites(const CompiledMap& new_map, const CompiledMap& old_map) {
  return {nearest_of(new_map, old_map), nearest_of(old_map, new_map)};
}

}  // namespace sightline
