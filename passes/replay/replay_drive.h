#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "passes/pass/pass_context.h"
#include "passes/replay/replayed_scan.h"

// A recording localized in one or more maps as a vehicle does it, scan after scan, without poses to
// compare with ("Replaying a recording" and "Several maps" in schemas/definitions.md).

namespace sightline {

struct ReplayedDrive {
  std::vector<ReplayedScan> scans;  // one for each that was listed
  std::uint32_t lost_count = 0;     // how often it was lost after it had been localized
};

// Each scan starts where the two before it predict; the first, and those after a pause of 2 s or a
// loss, from `T_world_start`, a pose of the recording or the last pose, and from starts up to 3 m
// around it. There, every tenth scan and where the plan doubts, it is checked whether the scan
// shows the map. Where no pose is known, and at every fifth scan of a lost vehicle, all maps are
// searched whole (find_place); a scan that fits two places is not found. Scans that cannot be read
// or have no returns are left out with a warning, up to 5 %; a map that cannot be read, with a
// warning, unless it is the last. The same bits for any number of threads, but time_ms. Errors:
// no-overlap (the start is beside the map; none of the first 20 scans shows the map, or fits one
// place of it clearly better than others), those of reading a scan, where there are more than 5 %
// of them, of JoinedMaps::go_to, and of MapReader::look_plan and sites.
Result<ReplayedDrive> replay_drive(const PassContext& ctx, const ReplayOptions& options,
                                   const ReplayInputs& inputs);

}  // namespace sightline
