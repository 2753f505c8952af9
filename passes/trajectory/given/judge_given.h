#pragma once

#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/given/disagreements.h"
#include "passes/trajectory/given/jumps.h"
#include "passes/trajectory/given/sharpening.h"

namespace sightline {

// Where given poses are contradicted.
struct GivenVerdict {
  std::vector<PoseJump> jumps;
  std::vector<PoseDisagreement> disagreements;  // of the other poses
};
// Errors: those of reading a scan.
Result<GivenVerdict> judge_given(const Drive& drive, const JumpLimits& limits,
                                 const GivenPoses& given, const Odometry& odometry);

// The poses without those of jumps.
GivenPoses without_jumps(GivenPoses given, const std::vector<PoseJump>& jumps);

// One sentence each, without its full stop; the first five places are named.
std::string jumps_text(const std::vector<PoseJump>& jumps, const Drive& drive);
std::string disagreements_text(const std::vector<PoseDisagreement>& found, const Drive& drive);
std::string sharpening_text(const Sharpening& found, const std::vector<WayStretch>& stretches,
                            const Drive& drive);

// Error: mismatched-inputs, at the worst scan.
Error refused_jumps(const std::vector<PoseJump>& jumps, const Drive& drive);
Error refused_disagreements(const std::vector<PoseDisagreement>& found, const Drive& drive);

}  // namespace sightline
