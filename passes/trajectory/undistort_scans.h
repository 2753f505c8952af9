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

// The drive with every scan as if it had been measured at once, at its stamp: a point with a time
// of its own moves by what the vehicle moved between that time and the stamp. Between two poses of
// the trajectory the vehicle moves evenly, in position and (about one axis) in rotation; before the
// first pose, behind the last one and next to a gap of more than 1.5 s, or a step out of keeping
// with those around it, it moves on as it did on the other side of the scan, and stands still where
// there is none. Where the drive has turn rates of an inertial unit, they tell how it turned
// between two poses ("Turning within a scan" in schemas/definitions.md), if that makes the scans
// lie on each other more sharply (see with_turns_that_pay, which warns of what it did).
//
// The scans are changed when they are read, one in memory; they carry no times any more. Where no
// scan has times, those that the order of its points tells are tried (see sharpest_sweep), and
// kept where they make the scans lie on each other more sharply; else, or when disabled, it is the
// same drive. Of several drives (join-drives) each is treated so for itself. Warns when times are
// there and not used, and of scans that are taken to stand still. Errors: mismatched-inputs (not
// one pose for each scan) and what reading a scan says.
Result<Drive> undistort_scans(PassContext& ctx, const UndistortScansOptions& options,
                              const Drive& drive, const Trajectory& trajectory);
inline constexpr Pass kUndistortScans{"undistort-scans", 5, "undistorted", "Motion during a scan",
                                      &undistort_scans};

}  // namespace sightline
