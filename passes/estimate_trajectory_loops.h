#pragma once

#include <vector>

#include "compiler/base/result.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/drive.h"
#include "passes/estimate_trajectory_graph.h"
#include "passes/estimate_trajectory_odometry.h"

namespace sightline {

// Edges between scans of places that the route comes back to: near each other by odometry, far
// apart on the way, and confirmed by matching the later scan to a map of the earlier visit.
// Matching candidates is shared by ctx.threads; the edges do not depend on how many there are.
// Error: what reading a scan says.
Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry);

}  // namespace sightline
