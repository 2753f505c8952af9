#pragma once

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

// Whether the turn rates of a drive pay.

namespace sightline {

// A drive of one part with point times, with those turn rates that make its scans lie on each other
// more sharply than even turning between poses does, both undistorted with the trajectory; without
// any where they do not. Tried on the up to 60 scans in a row where the two differ most. Where the
// rates fit the poses better with another clock (turn_clock), they are moved to that of the scans.
// A warning says what was taken, what was moved and by how much; there is none where the drive has
// no turn rates.
Result<Drive> with_turns_that_pay(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// The drive without turn rates.
Drive without_turns(Drive drive);

}  // namespace sightline
