#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"

namespace sightline {

// A stretch on which given poses move otherwise than matched scans.
struct PoseDisagreement {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  double given_m = 0.0;  // how far the last one is from the first
  double matched_m = 0.0;
  double off_m = 0.0;  // the difference of the two motions
  double off_rad = 0.0;
  std::uint32_t worst = 0;  // the scan that is off most, relative to the first
  double worst_off_m = 0.0;
};

// Compares motions over about 3 m of way: 0.15 m and 5 % of the way, or 1 degree and 5 % of the
// turn, are allowed. Stretches that touch are one. Left out are scans without a given pose, those
// that could not be matched, and motions that the scans do not contradict (is_contradicted), unless
// they are off by 1 m and 25 % of the way. Errors: those of reading a scan.
Result<std::vector<PoseDisagreement>> find_disagreements(const Drive& drive,
                                                         const GivenPoses& given,
                                                         const Odometry& odometry);

std::string to_text(const PoseDisagreement& disagreement, const Drive& drive);

}  // namespace sightline
