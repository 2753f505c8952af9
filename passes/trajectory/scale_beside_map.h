#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/pass/pass_context.h"

// Whether a drive agrees with a map on how far away things are; part of align-drive.

namespace sightline {

// What a drive measures to what the map says: 1 where its scans do not say that it is another
// ("Trajectories" in schemas/definitions.md). Eight scans, evenly over those that match, are
// matched at several scales (best_scale), from where they lie in the map: `T_map_lidar` of all
// scans. Shared by ctx.threads. Error: what reading a scan says.
Result<double> scale_beside_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                const std::vector<Pose>& T_map_lidar,
                                const std::vector<std::uint8_t>& is_matched);

}  // namespace sightline
