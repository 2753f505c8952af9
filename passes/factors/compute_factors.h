#pragma once

#include <map>
#include <utility>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/site_views.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/matching/localizer.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Where the NDs of each tile lie in a map: [first, second) of its list.
using TileIndex = std::map<TileKey, std::pair<std::uint32_t, std::uint32_t>>;

// What the factors of all sites share. Refers to the map.
struct FactorWorld {
  const NdtMap& map;
  MatchGrid grid;
  Localizer localizer;
  TileIndex index;
  std::vector<double> ranges_m;
};
// Error: bad-value (ranges that do not ascend from above 0).
Result<FactorWorld> make_factor_world(const NdtMap& map, const std::vector<double>& ranges_m);

struct SeenFactors {
  FactorTable table;
  std::size_t point_count = 0;      // of the virtual scans
  std::size_t unmatched_count = 0;  // of them: in no valid ND
};

// The map factors of sites at every range (schemas/definitions.md, "Factors from the paper" and
// "Factors from a virtual scan"). A site depends on NDs within its longest range plus 2 sqrt(2) m
// and two cells, the last two factors also on kFarthestFound_m more. Error: mismatched-inputs
// (frames or sites that differ, or depth images or scans that end before the longest range).
Result<SeenFactors> compute_factors(const PassContext& ctx, const FactorWorld& world,
                                    const Sites& sites, const DepthImages& depth,
                                    const VirtualScans& scans);

}  // namespace sightline
