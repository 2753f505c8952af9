#pragma once

#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

// Part of estimate-trajectory.

namespace sightline {

// Odometry::overlap of every scan where the odometry has it. For who followed given poses all the
// way, which does not ask. Shared by ctx.threads. Errors: what reading a scan says.
Result<std::vector<std::optional<double>>> overlaps_along(const PassContext& ctx,
                                                          const Drive& drive, double local_map_m,
                                                          const Odometry& odometry);

}  // namespace sightline
