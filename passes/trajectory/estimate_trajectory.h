#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass.h"
#include "passes/trajectory/local/estimate_options.h"

namespace sightline {

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options);

// Where the vehicle was at each scan of the drive, in the drive's frame.
// Estimated: the first scan's vehicle frame (refined: where given poses put it). Each scan is
// matched by NDT to a map of the latest ones from where constant velocity would take it; a pose
// graph takes that odometry, loops where the route comes back to a place, and, when refining, the
// given poses; then the small planes that several scans saw say how well each pose is known, and
// where poses were given all are adjusted to them. Given poses are compared with that odometry
// (passes/trajectory/given) and kept, those of several drives refined together. Scans are taken as
// rigid first; where their points have times, or lie in an order that tells these (see
// swept_drives), estimated poses of the undistorted scans take over where they lay these more
// sharply (see estimate_undistorted). A warning says where loops contradict the answer
// (find_contradictions). Errors: no-poses (mode given or refine without),
// mismatched-inputs (poses are refused; place: the worst scan), trajectory-lost (matching fails and
// no given pose helps; place: the scan), drive-too-short (fewer than two scans to match), and what
// reading a scan says.
Result<Trajectory> estimate_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                       const Drive& drive);
inline constexpr Pass kEstimateTrajectory{"estimate-trajectory", 22, "trajectory",
                                          "Where the vehicle was", &estimate_trajectory};

}  // namespace sightline
