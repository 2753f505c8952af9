#include "passes/factors/group_nds.h"

#include <algorithm>

#include "formats/base/parallel.h"
#include "passes/factors/paper/normal_entropy.h"

namespace sightline {
namespace {

// So that what lies at exactly the reach is decided by its distance, not by rounding here.
constexpr double kSlack_m = 0.01;

bool is_within(double reach_m, const Eigen::Vector3d& mean_m, std::span<const Site> sites) {
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    return (mean_m - site.p_map_m).squaredNorm() <= reach_m * reach_m;
  });
}

std::vector<Nd> nds_within(double reach_m, const NdtMap& map, const TileIndex& index,
                           std::span<const Site> sites) {
  Eigen::Vector3d low_m = sites[0].p_map_m;
  Eigen::Vector3d high_m = sites[0].p_map_m;
  for (const Site& site : sites) {
    low_m = low_m.cwiseMin(site.p_map_m);
    high_m = high_m.cwiseMax(site.p_map_m);
  }
  const TileKey low = tile_key(low_m.array() - reach_m, map.tile_m);
  const TileKey high = tile_key(high_m.array() + reach_m, map.tile_m);
  std::vector<Nd> found;
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      const auto tile = index.find({x, y});
      if (tile == index.end()) continue;
      for (std::uint32_t i = tile->second.first; i < tile->second.second; ++i) {
        if (is_within(reach_m, map.nds[i].mean_m, sites)) found.push_back(map.nds[i]);
      }
    }
  }
  return found;
}

}  // namespace

TileIndex tile_index(const NdtMap& map) {
  TileIndex index;
  for (std::uint32_t i = 0; i < map.nds.size(); ++i) {
    const TileKey tile = tile_of(map.nds[i].key, map.cell_m, map.tile_m);
    index.try_emplace(tile, i, i).first->second.second = i + 1;
  }
  return index;
}

GroupNds gather_nds(const NdtMap& map, const TileIndex& index, const MatchGrid& grid,
                    const SiteGroup& group, int threads) {
  GroupNds found;
  found.nds = nds_within(group.reach_m + kSlack_m, map, index, group.sites);
  for (const Nd& nd : found.nds) {
    found.all.push_back(static_cast<std::uint32_t>(found.all.size()));
    found.dimension_class.push_back(dimension_class(nd));
    const bool is_planar = found.dimension_class.back() == 2;
    found.normal_bin.push_back(is_planar ? normal_bin(nd.eigenvectors.col(2)) : -1);
  }
  found.self_score = parallel_map<ShiftGrid>(
      found.nds.size(), threads, [&](std::size_t i) { return self_score(found.nds[i], grid); });
  return found;
}

}  // namespace sightline
