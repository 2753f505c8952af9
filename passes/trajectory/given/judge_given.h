#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/given/disagreements.h"
#include "passes/trajectory/given/jumps.h"
#include "passes/trajectory/given/sharpening.h"

// What the scans say of the poses that came with them; part of estimate-trajectory.

namespace sightline {

// Where given poses (T_map_lidar, one a scan, none where there is none) are not as the scans show.
struct GivenVerdict {
  std::vector<PoseJump> jumps;
  std::vector<PoseDisagreement> disagreements;  // of the other poses
};
// Errors: what reading a scan says.
Result<GivenVerdict> judge_given(const Drive& drive, const JumpLimits& limits,
                                 const std::vector<std::optional<Pose>>& given,
                                 const Odometry& odometry);

// The poses but those of jumps.
std::vector<std::optional<Pose>> without_jumps(std::vector<std::optional<Pose>> given,
                                               const std::vector<PoseJump>& jumps);

// One sentence each, without its point; the first few places are named.
std::string jumps_text(const std::vector<PoseJump>& jumps, const Drive& drive);
std::string disagreements_text(const std::vector<PoseDisagreement>& found, const Drive& drive);
std::string sharpening_text(const Sharpening& found, const std::vector<WayStretch>& stretches,
                            const Drive& drive);

// Error: mismatched-inputs, at the worst scan.
Error refused_jumps(const std::vector<PoseJump>& jumps, const Drive& drive);
Error refused_disagreements(const std::vector<PoseDisagreement>& found, const Drive& drive);

}  // namespace sightline
