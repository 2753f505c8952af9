#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

namespace sightline {

// Scans whose given poses are not where the other given poses and the scans put them.
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

// Given poses are cut where from one to the next they move otherwise than the scans by more than
// the limits and a tenth of the motion, and the scans contradict that (is_contradicted). The
// longest part is believed, and with it each further part that lies where odometry leads from the
// nearest believed one; the others are jumps. Ascending. Errors: what reading a scan says.
Result<std::vector<PoseJump>> find_jumps(const Drive& drive, const JumpLimits& limits,
                                         const std::vector<std::optional<Pose>>& given,
                                         const Odometry& odometry);

// "scans 30 to 35 ... (file)": where, and how far off.
std::string to_text(const PoseJump& jump, const Drive& drive);

}  // namespace sightline
