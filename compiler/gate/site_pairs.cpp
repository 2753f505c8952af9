#include "compiler/gate/site_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace sightline {
namespace {

Eigen::Vector3d p_world_m(const CompiledMap& map, std::size_t site) {
  return map.sites.sites[site].p_map_m + map.sites.frame.origin_world_m;
}

// Sites by square cells of one reach, so that all that can be near lies in nine of them.
struct SiteGrid {
  struct Entry {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::uint32_t site = 0;
    friend auto operator<=>(const Entry&, const Entry&) = default;
  };
  double cell_m = 1.0;
  std::vector<Entry> entries;  // ascending

  [[nodiscard]] std::int64_t cell_of(double coordinate_m) const {
    return static_cast<std::int64_t>(std::floor(coordinate_m / cell_m));
  }
};

SiteGrid grid_of(const CompiledMap& map, double cell_m) {
  SiteGrid grid{cell_m, {}};
  for (std::uint32_t site = 0; site < map.sites.sites.size(); ++site) {
    const Eigen::Vector3d p_m = p_world_m(map, site);
    grid.entries.push_back({grid.cell_of(p_m.x()), grid.cell_of(p_m.y()), site});
  }
  std::ranges::sort(grid.entries);
  return grid;
}

std::optional<std::uint32_t> nearest(const SiteGrid& grid, const CompiledMap& map,
                                     const Eigen::Vector3d& p_m) {
  std::optional<std::uint32_t> best;
  double best_m = grid.cell_m;
  const std::int64_t y = grid.cell_of(p_m.y());
  for (std::int64_t x = grid.cell_of(p_m.x()) - 1; x <= grid.cell_of(p_m.x()) + 1; ++x) {
    auto entry = std::ranges::lower_bound(grid.entries, SiteGrid::Entry{x, y - 1, 0});
    for (; entry != grid.entries.end() && entry->x == x && entry->y <= y + 1; ++entry) {
      const double away_m = (p_world_m(map, entry->site) - p_m).norm();
      const bool is_nearer = best ? std::tie(away_m, entry->site) < std::tie(best_m, *best)
                                  : away_m <= best_m;
      if (!is_nearer) continue;
      best = entry->site;
      best_m = away_m;
    }
  }
  return best;
}

std::vector<std::optional<std::uint32_t>> nearest_of(const CompiledMap& from,
                                                     const CompiledMap& to) {
  const SiteGrid grid = grid_of(to, to.reach_m);
  std::vector<std::optional<std::uint32_t>> found;
  for (std::size_t site = 0; site < from.sites.sites.size(); ++site) {
    found.push_back(nearest(grid, to, p_world_m(from, site)));
  }
  return found;
}

}  // namespace

SitePairs pair_sites(const CompiledMap& new_map, const CompiledMap& old_map) {
  return {nearest_of(new_map, old_map), nearest_of(old_map, new_map)};
}

}  // namespace sightline
