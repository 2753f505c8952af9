#pragma once

#include "formats/annotation/measured_drives.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass.h"

// Several drives that were localized in one map, brought together.

namespace sightline {

// `first` and `later` are the first localization drive and a later one, `first_errors` and
// `later_errors` what they found. A drive that was measured at no site is left out, and so is a
// later one whose sensor is not that of the first; a warning names it. Error: mismatched-inputs
// where both were not measured at the same sites by the same looks.
Result<MeasuredDrives> join_errors(PassContext& ctx, const NoOptions& options, const Drive& first,
                                   const Drive& later, const MeasuredError& first_errors,
                                   const MeasuredError& later_errors);
inline constexpr Pass kJoinErrors =
    Pass{"join-errors", 1, "measured-drives", "What several drives found, together", &join_errors}
        .in(Stage::kLearn);

// The same where some were joined before.
Result<MeasuredDrives> join_more_errors(PassContext& ctx, const NoOptions& options,
                                        const Drive& first, const Drive& later,
                                        const MeasuredDrives& joined,
                                        const MeasuredError& later_errors);
inline constexpr Pass kJoinMoreErrors = variant_of(kJoinErrors, &join_more_errors);

// One table for whoever judges or counts: the measured sites take the rows of the drives in turn,
// so that each drive speaks for as many of them, and a share of these sites is one of all drives.
// Where a drive was not measured, the next one speaks. Its name is those of all. Error: no-overlap
// where no drive is left.
Result<MeasuredError> pool_errors(PassContext& ctx, const NoOptions& options,
                                  const MeasuredDrives& measured);
inline constexpr Pass kPoolErrors = Pass{"pool-errors", 1, "measured-in-turn",
                                         "Several drives, each at every n-th site", &pool_errors}
                                        .in(Stage::kLearn);

}  // namespace sightline
