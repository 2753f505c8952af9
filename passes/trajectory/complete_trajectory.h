#pragma once

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"

namespace sightline {

// One pose for each scan of a drive of several sensors (join_sensors), from the trajectory of its
// first sensor's scans: their poses are kept, those of others are interpolated at their times,
// linear in position, slerp in rotation. Everything else of the trajectory is kept. Error:
// mismatched-inputs (not one pose for each scan of the first sensor, or a scan that is not between
// two of them).
Result<Trajectory> complete_trajectory(PassContext& ctx, const NoOptions& options,
                                       const Drive& drive, const Trajectory& first_sensor);
inline constexpr Pass kCompleteTrajectory =
    Pass{"complete-trajectory", 2, "joined-trajectory", "Poses for the scans of every sensor",
         &complete_trajectory}
        .in(Stage::kTiles);

}  // namespace sightline
