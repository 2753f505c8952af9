#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/drive/notice.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Compares the returns of up to five scans with the sensor profile of their recording, and warns
// (unlike-profile, which is also added to `notices`) where another LiDAR made them, with the
// profile that `init` guesses: by returns outside its beams, view or range, beams or a view without
// returns, other beams, or more returns than rays. Needs 1000 returns. Errors: unlike-profile where
// half of the returns or more are outside its beams or view, and those of read_recorded_scan.
Result<void> check_sensor(PassContext& ctx, const Recording& recording,
                          std::vector<Notice>& notices);

}  // namespace sightline
