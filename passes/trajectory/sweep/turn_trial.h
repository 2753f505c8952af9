#pragma once

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// A drive of one part with point times, with its turn rates where its scans, undistorted with the
// trajectory, are then sharper than by even turning between poses; else without. Tried on the up to
// 60 scans in a row where the two differ most. Rates that fit the poses better with another clock
// (turn_clock) are moved to that of the scans. Warns of what was used and moved; not where there
// are no turn rates.
Result<Drive> with_imu_if_sharper(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// The drive without turn rates.
Drive without_turns(Drive drive);

}  // namespace sightline
