#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// A drive of one part with point times, with its turn rates where its scans, undistorted with the
// trajectory, are then sharper than by even turning between poses; else without. Tried on the up to
// 60 scans in a row where the two differ most. Rates that fit the poses better with another clock
// (turn_clock) are moved to that of the scans. Warns of what was used and moved; not where there
// are no turn rates.
Result<Drive> with_imu_if_sharper(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// The drive without turn rates.
Drive without_turns(Drive drive);

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
