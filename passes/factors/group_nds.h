#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/factors/paper/self_score.h"

namespace sightline {

// Where the NDs of each tile lie in a map: [first, second) of its list.
using TileIndex = std::map<TileKey, std::pair<std::uint32_t, std::uint32_t>>;
TileIndex tile_index(const NdtMap& map);

// The NDs that a group of neighbouring sites looks at, and what each is for all of them. Lists run
// in parallel.
struct GroupNds {
  std::vector<Nd> nds;
  std::vector<std::uint32_t> all;  // 0, 1, 2, ...
  std::vector<int> dimension_class;
  std::vector<int> normal_bin;  // -1 where the ND is not planar
  std::vector<ShiftGrid> self_score;
};

// Sites, at least one, and how far they look.
struct SiteGroup {
  std::span<const Site> sites;
  double reach_m = 0.0;
};

// All NDs within reach of any site of the group; a few beyond may come along. `grid` and `index`
// were made from `map`.
GroupNds gather_nds(const NdtMap& map, const TileIndex& index, const MatchGrid& grid,
                    const SiteGroup& group, int threads);

}  // namespace sightline
