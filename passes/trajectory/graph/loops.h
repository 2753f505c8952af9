#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"

namespace sightline {

// Which visits are compared: the later one is a scan from `from` on, the earlier one a scan before
// `before`.
struct LoopSearch {
  std::size_t from = 0;
  std::size_t before = static_cast<std::size_t>(-1);
};

// Edges between scans of places that the route comes back to: near each other by odometry, far
// apart on the way, and confirmed by matching the later scan to a map of the earlier visit.
// Matching candidates is shared by ctx.threads; the edges do not depend on how many there are.
// Error: what reading a scan says.
Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry, const LoopSearch& search = {});

}  // namespace sightline
