#pragma once

#include <optional>
#include <vector>

#include "formats/foreign/recording/recording.h"
#include "formats/geometry.h"
#include "passes/ingest/top_view.h"

namespace sightline {

// Scans that contradict their neighbours, such as one that is turned round or one of another
// place. Up to three consecutive scans are odd where the scans before and after them agree
// (agreement) and each of them agrees with neither, within 100 degrees and by any given motion: a
// sensor that swings there and back is not odd, nor is a scan whose pose is wrong. At the beginning
// and end of the drive: one scan, where the next three agree. Scans with few upright returns are
// not judged. One flag a view, true: odd.
//
// `views`: of consecutive scans. `T_world_sensor`: level_sensor_poses(). Up to `threads` threads
// (0: all).
std::vector<bool> odd_scans(const std::vector<TopView>& views,
                            const std::vector<std::optional<Pose>>& T_world_sensor, int threads);

// The given poses of a recording's sensor in axes parallel to the vehicle's, as those of a TopView.
std::vector<std::optional<Pose>> level_sensor_poses(const Recording& recording);

}  // namespace sightline
