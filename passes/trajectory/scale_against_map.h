#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// The ratio of a drive's distances to the map's; 1 where its scans do not differ clearly
// ("Trajectories" in schemas/definitions.md). Eight scans, evenly over the matched ones, are
// matched at several scales (best_scale), from their poses in the map: `T_map_lidar` of all scans.
// Shared by ctx.threads. Error: that of reading a scan.
Result<double> scale_against_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                 const std::vector<Pose>& T_map_lidar,
                                 const std::vector<std::uint8_t>& is_matched);

}  // namespace sightline
