#pragma once

#include "formats/base/result.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Compares the returns of up to five scans with the sensor profile of their recording, and warns
// (unlike-profile) where it is not that of the LiDAR that made them, with what `init` would guess:
// where 2 % and more of the returns lie over a degree outside its beams or its azimuth view, or
// fill a sector that is narrower than its view by 20 degrees and more; where its beams go on 5
// degrees and more beyond the last of them, though returns end there all at once or ground must lie
// there; where the beams that returns stand at are those of another profile; where a scan has over
// 2.5 times as many returns as the profile has rays; where 5 % and more of the returns lie beyond
// its range. Says nothing of fewer than 1000 returns. The map itself is the same with any beams;
// factors, and what they predict, are not. Errors: unlike-profile (half of the returns and more
// lie outside its beams or its view: they are of another LiDAR, or in another frame than the
// sensor's), and those of read_recorded_scan.
Result<void> check_sensor(PassContext& ctx, const Recording& recording);

}  // namespace sightline
