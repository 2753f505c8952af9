#pragma once

#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass.h"

namespace sightline {

// Which share of the returns around each site was removed as moving: of the scans within 5 m of it,
// one in 2 m of way, together; infinite where there is none. Shared by ctx.threads. Errors: those
// of reading a scan.
Result<SiteColumn> count_removed(PassContext& ctx, const NoOptions& options,
                                 const SurfacePoints& points, const Sites& sites);
inline constexpr Pass kCountRemoved =
    Pass{"count-removed", 1, "removed-share", "Share of moving objects", &count_removed}.in(
        Stage::kTiles);

}  // namespace sightline
