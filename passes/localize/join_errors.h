#pragma once

#include "formats/annotation/measured_drives.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass.h"

// Several drives that were localized in one map, brought together.

namespace sightline {

// What localization drives found, each by itself: `errors` are those of `drives`, one of each, in
// the order in which they were named. A drive that was measured at no site is left out, and so is
// one whose sensor is not that of the first; a warning names it. Error: mismatched-inputs where not
// all were measured at the same sites by the same looks.
Result<MeasuredDrives> join_errors(PassContext& ctx, const NoOptions& options, Many<Drive> drives,
                                   Many<ByFamily<MeasuredError>> errors);
inline constexpr Pass kJoinErrors =
    Pass{"join-errors", 1, "measured-drives", "Joining the errors of several drives", &join_errors}
        .in(Stage::kLearn);

// One table for evaluation and counts: the measured sites take the rows of the drives in turn, so
// that each drive stands for as many of them, and a share of these sites is one of all drives.
// Where a drive was not measured, the next one is taken. Its name is those of all. Error:
// no-overlap where no drive is left.
Result<ByFamily<MeasuredError>> pool_errors(PassContext& ctx, const NoOptions& options,
                                            const MeasuredDrives& measured);
inline constexpr Pass kPoolErrors = Pass{"pool-errors", 1, "measured-in-turn",
                                         "Combining drives, each at every n-th site", &pool_errors}
                                        .in(Stage::kLearn);

}  // namespace sightline
