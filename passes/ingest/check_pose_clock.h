#pragma once

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// Refuses poses whose clock differs from that of the scans by a constant of 0.5 to 40 s (leap
// seconds, for example), where the scans show it: with the poses at another time, returns from
// upright surfaces of up to 12 pairs of scans fall on each other far better. Needs poses with times
// of their own (Recording::pose_rows); where the vehicle moves evenly all times fit equally, and
// nothing is refused. Errors: mismatched-inputs, and those of read_listed_scan.
Result<void> check_pose_clock(const Recording& recording);

}  // namespace sightline
