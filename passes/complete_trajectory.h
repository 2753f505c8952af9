#pragma once

#include <vector>

#include "compiler/pipeline/options.h"
#include "compiler/pipeline/pass_context.h"
#include "formats/drive.h"
#include "formats/trajectory.h"

namespace sightline {

inline constexpr std::uint32_t kCompleteTrajectoryVersion = 2;

struct CompleteTrajectoryOptions {};
std::vector<OptionField> option_fields(CompleteTrajectoryOptions& options);

// One pose for each scan of a drive of several sensors (join_sensors), from the trajectory of its
// first sensor's scans: theirs are kept, those of others are interpolated at their times, linear in
// position, slerp in rotation. What else a trajectory says stays.
// Error: mismatched-inputs (not one pose for each scan of the first sensor, or a scan that is not
// between two of them).
Result<Trajectory> complete_trajectory(PassContext& ctx, const CompleteTrajectoryOptions& options,
                                       const Drive& drive, const Trajectory& first_sensor);

}  // namespace sightline
