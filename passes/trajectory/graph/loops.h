#pragma once

#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"

namespace sightline {

// Which visits are compared: later scans from `from` on, earlier ones before `before`.
struct LoopSearch {
  std::size_t from = 0;
  std::size_t before = static_cast<std::size_t>(-1);
};

// Edges between scans of places that the route comes back to: near each other by odometry, far
// apart on the way, on one level, and confirmed by matching the later scan to a map of the earlier
// visit. Within a piece heights may differ by 1 m, and by three standard deviations of odometry's
// `steps` between all scans (steps_of), before the match and by it. Where heights by odometry
// differ by 1 m and more, the map around the lower scan has no surface on the line to the upper
// one. Candidates are matched on ctx.threads; the edges do not depend on their number. Error: that
// of reading a scan.
Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry,
                                          std::span<const GraphEdge> steps,
                                          const LoopSearch& search = {});

}  // namespace sightline
