#pragma once

#include "formats/drive/drive.h"
#include "passes/pass/pass.h"

namespace sightline {

// One drive of several through the same place by the same vehicle: the scans of each of `later`,
// drives of one part, follow those before them, as a part of their own. Name, sensor and frame are
// those of `first`, the frame that of the first which has poses. Even scans stay even. Turn rates
// are kept with the parts that have them.
//
// Parts follow each other in the order in which they are given. A later one whose times begin
// before the last part ended, or less than kPauseBetweenParts_ns behind it, is moved in time as a
// whole; where its times were those of a clock, a warning says by how much. A drive with another
// sensor, or with the same one elsewhere on the vehicle, is left out with a warning that names it.
Result<Drive> join_drives(PassContext& ctx, const NoOptions& options, const Drive& first,
                          Many<Drive> later);
inline constexpr Pass kJoinDrives =
    Pass{"join-drives", 1, "drives", "Several drives in one", &join_drives}.in(Stage::kGraph);

}  // namespace sightline
