#pragma once

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/surroundings/surface_points.h"
#include "formats/surroundings/tile_drives.h"
#include "passes/pass/pass.h"

namespace sightline {

struct CountDrivesOptions {
  double tile_m = 64.0;
  double step_m = 2.0;  // scans of a drive that are looked at lie at least so far apart
};
std::vector<OptionField> option_fields(CountDrivesOptions& options);

// For each drive and tile, map frame: how many of its scans left ten standing returns or more
// there, and how many that are not laid, since they show nothing new, were taken there. Of every
// drive scans step_m apart are counted, from its first on. Errors: mismatched-inputs (the points or
// the trajectory are not of this drive), and those of reading a scan.
Result<TileDrives> count_drives(PassContext& ctx, const CountDrivesOptions& options,
                                const Drive& drive, const Trajectory& trajectory,
                                const SurfacePoints& points);
inline constexpr Pass kCountDrives =
    Pass{"count-drives", 2, "tile-drives", "Drives and days of each tile", &count_drives}.in(
        Stage::kTiles);

}  // namespace sightline
