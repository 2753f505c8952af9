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

// What the factors of all sites share: made once of the map, to which it refers.
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

// The map factors of sites at every range, as defined in schemas/definitions.md. The paper's:
// feature_count, d1_count, d2_count, d3_count, d1_ratio, d2_ratio, d3_ratio, occupancy_ratio,
// normal_entropy (bits), r_average (m), score_entropy (bits); and of the virtual scan: crlb_max,
// crlb_min (m), crlb_heading (of the weakest direction, degrees in [0, 180) from map +x), crlb_yaw
// (rad), hz_lmin, flat_050, virtual_points, virtual_error (m), rival_score. A site depends on NDs
// within its longest range plus 2 sqrt(2) m and two cells, the last two factors on NDs as far
// beyond that as the localizer strays, and on nothing else. Sites work side by side on ctx.threads
// threads. Error: mismatched-inputs (frames or sites that differ, or depth images or scans that end
// before the longest range).
Result<SeenFactors> compute_factors(const PassContext& ctx, const FactorWorld& world,
                                    const Sites& sites, const DepthImages& depth,
                                    const VirtualScans& scans);

}  // namespace sightline
