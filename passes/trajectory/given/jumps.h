#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

namespace sightline {

// Scans whose given poses are not where the other given poses and matching put them.
struct PoseJump {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  std::uint32_t worst = 0;
  double off_m = 0.0;  // of the worst one
  double off_rad = 0.0;
};

struct JumpLimits {
  double off_m = 1.5;
  double off_rad = 0.1;
};

// Given poses are cut where from one to the next they move otherwise than matched scans by more
// than the limits and a tenth of the motion, and the scans contradict that (is_contradicted). The
// longest part is kept, and each further part that is where odometry leads from the nearest kept
// one; the others are jumps. Ascending. Errors: those of reading a scan.
Result<std::vector<PoseJump>> find_jumps(const Drive& drive, const JumpLimits& limits,
                                         const GivenPoses& given, const Odometry& odometry);

// "scans 30 to 35 ... (file)": the scans, and how far off they are.
std::string to_text(const PoseJump& jump, const Drive& drive);

}  // namespace sightline
