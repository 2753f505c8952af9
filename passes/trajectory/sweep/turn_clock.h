#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"

namespace sightline {

// Turn rates compared with the turning of the poses.
struct TurnClock {
  bool is_known = false;      // the vehicle turned enough
  std::int64_t ahead_ns = 0;  // of the rates' clock, relative to that of the poses
  // Share of the poses' turning, squared and about its mean, that the rates explain: with the
  // clocks as they are, and with the rates moved by ahead_ns. At most 1; below 0 where rates and
  // poses contradict each other.
  double explained_as_is = 0.0;
  double explained_moved = 0.0;
};

// Compares the mean turn rate between each two poses with that of the rates, for clocks up to 0.5 s
// apart in steps of 5 ms ("Turning within a scan" in schemas/definitions.md, v1). Poses at most
// 0.5 s apart and of one piece count, 20 at least.
TurnClock turn_clock(const Trajectory& trajectory, std::span<const TurnRate> rates);

// The rates on the clock of the scans.
std::vector<TurnRate> moved_by(std::span<const TurnRate> rates, std::int64_t ahead_ns);

}  // namespace sightline
