#pragma once

#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"

namespace sightline {

struct UndistortScansOptions {
  bool enabled = true;
};
std::vector<OptionField> option_fields(UndistortScansOptions& options);

// The drive with every scan as if it had been measured at once, at its stamp, by the motion of the
// trajectory and, where they make scans sharper, by turn rates ("Times of points and several
// sensors" in schemas/definitions.md). Scans are changed when they are read, and lose their times.
// Where no scan has times, those by the order of its points are tried (sharpest_sweep). Each of
// several drives (join-drives) is treated by itself. Without times, where undistorting does not
// make scans sharper, or when disabled: the drive as it is. Warns of times that are not used, of
// scans taken to stand still, and of turn rates. Errors: mismatched-inputs (not one pose for each
// scan) and those of reading a scan.
Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kUndistortScans =
    Pass{"undistort-scans", 7, "undistorted", "Removing motion within scans", &undistort_scans}
        .in(Stage::kTiles)
        .with({.scan_s = 0.0003, .million_points_s = 0.01, .without_poses_s = 0.08});

}  // namespace sightline
