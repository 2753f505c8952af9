#pragma once

#include <cstdint>
#include <string>

#include "formats/annotation/range_table.h"
#include "passes/model/promise/calibration_drives.h"

// The one sentence of a promise: of which drives and places, what is promised, or why nothing is.

namespace sightline {

// "3.1 % missed out of fold in 70 blocks of 7 places, 14 drives"
std::string observed_misses(const LimitPromise& promise);

// Of a promise that is earned. It is about the mean over places: `worst_place_miss_share` is how
// far one may lie from it.
std::string earned_statement(const LimitPromise& promise, double worst_place_miss_share);

// Of a threshold whose bound holds, set on drives that the trees learnt from or on one alone.
std::string this_drive_statement(const LimitPromise& promise, const TrainingCard& card);

// Of a threshold that no bound was reached for; `needed_blocks`: fewer cannot reach it.
std::string unearned_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives,
                               std::uint32_t needed_blocks);

// "; 2 % is not earned: ..." of the next stricter share.
std::string stricter_statement(const LimitPromise& promise,
                               const CalibrationDrives& calibration_drives, double stricter_alpha,
                               std::uint32_t needed_blocks);

// Whether errors are those against known poses. A match to the very map is no truth: against it
// errors vanish with range by construction.
bool are_poses_known(const TrainingCard& card);

// Whether blocks and buffer are so long that blocks do not see the same walls.
bool are_blocks_independent(const TrainingCard& card);

}  // namespace sightline
