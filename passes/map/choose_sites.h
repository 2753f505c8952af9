#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ChooseSitesOptions {
  double spacing_m = 1.0;
  double largest_gap_m = 5.0;  // at least; three median steps, up to 15 m, if that is more
  ScanSelection scans = ScanSelection::kAll;  // whose poses make the route: all, even, odd
};
std::vector<OptionField> option_fields(ChooseSitesOptions& options);

// Route points every spacing_m of 3D arc length along the poses of the chosen scans, in the
// trajectory's frame ("Sites" v3 in schemas/definitions.md); places passed again in the same
// direction on the same level (formats/base/level.h) are left out. A site's p is the origin of
// T_map_vehicle * drive.sensor.T_vehicle_lidar. A warning where gaps between poses take over a
// tenth of the way. Errors: mismatched-inputs (the trajectory is not of this drive),
// drive-too-short (no pose chosen).
Result<Sites> choose_sites(PassContext& ctx, const ChooseSitesOptions& options, const Drive& drive,
                           const Trajectory& trajectory);
inline constexpr Pass kChooseSites =
    Pass{"choose-sites", 6, "sites", "Sites to annotate", &choose_sites}.in(Stage::kTiles);

}  // namespace sightline
