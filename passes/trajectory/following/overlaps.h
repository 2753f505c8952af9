#pragma once

#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

// Odometry::overlap of every scan, for odometry with given poses of all scans, which leaves it out.
// Shared by ctx.threads. Errors: those of reading a scan.
Result<std::vector<std::optional<double>>> overlaps_along(const PassContext& ctx,
                                                          const Drive& drive, double local_map_m,
                                                          const Odometry& odometry);

}  // namespace sightline
