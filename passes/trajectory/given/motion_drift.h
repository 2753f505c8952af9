#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/given/disagreements.h"

// Errors of given poses that grow or repeat all along a drive, where no single pose is wrong:
// another clock, another scale, a drift. They are found from motions over about 3 m whose every
// step was matched and is constrained by the scans.

namespace sightline {

// A clock of the poses that is ahead of that of the scans (behind where negative).
struct ClockShift {
  std::int64_t ahead_ns = 0;
  double off_m = 0.0;            // root mean square difference of motions, as given
  double corrected_off_m = 0.0;  // with the poses of the scans' clock
};

// A constant shift of 0.08 to 1 s that explains most of the difference between given and matched
// motions. None where the vehicle moves evenly, since all times then fit equally, and for a drive
// of several parts.
std::optional<ClockShift> find_clock_shift(const Drive& drive, const GivenPoses& given,
                                           const Odometry& odometry);

// The drive with its poses at the times of the scans by that clock, interpolated between the given
// ones; at an end of the drive they follow the matched motion.
Drive with_clock(Drive drive, const ClockShift& shift, const Odometry& odometry);

std::string to_text(const ClockShift& shift, const Drive& drive);

// How given poses move otherwise than matched scans, in the sensor's level axes: mean of the
// motions without the quarter that differs most.
struct MotionDrift {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  double way_m = 0.0;  // of the motions that were compared
  double along_m = 0.0;
  double aside_m = 0.0;
  double turn_rad = 0.0;
};

// Stretches of 100 m of compared way on which given poses drift from the scans by more than the
// limits and 2 % of the way.
std::vector<MotionDrift> find_drifts(const JumpLimits& limits, const GivenPoses& given,
                                     const Odometry& odometry);
std::string to_text(const MotionDrift& drift, const Drive& drive);

// How much longer the given way is than that of the scans, over the whole drive: 0.01 for 1 %. None
// below 0.7 %, where the compared way is shorter than 100 m, and where its quarters do not agree.
std::optional<double> find_scale_error(const GivenPoses& given, const Odometry& odometry);

}  // namespace sightline
