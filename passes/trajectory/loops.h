#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/odometry.h"
#include "passes/trajectory/pose_graph.h"

namespace sightline {

// Edges between scans of places that the route comes back to: near each other by odometry, far
// apart on the way, and confirmed by matching the later scan to a map of the earlier visit.
// Matching candidates is shared by ctx.threads; the edges do not depend on how many there are.
// Error: what reading a scan says.
Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry);

}  // namespace sightline
