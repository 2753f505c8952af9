#pragma once

#include <vector>

#include "compiler/pipeline/runner.h"
#include "formats/base/result.h"

namespace sightline {

// Reports a run on a file descriptor as one JSON object a line, for programs that show progress:
//   {"event":"started","pass":"build-ndt","step":6,"steps":21}
//   {"event":"progress","pass":"build-ndt","step":6,"steps":21,"done":80,"total":301,
//    "elapsed_s":0.412,"remaining_s":1.138,"run_remaining_s":31.4}
//   {"event":"warning","pass":"build-ndt","message":"..."}
//   {"event":"finished","pass":"build-ndt","step":6,"steps":21,"wall_s":1.52,"cpu_s":2.9,
//    "peak_memory_mib":211.0,"from_cache":false}
// Steps count from 1; "remaining_s" is of the pass, absent before anything is done, and
// "run_remaining_s" of the whole run, where `expected_s` names the seconds that each of its steps
// is expected to take. Progress comes at most five times a second, the last of a pass always. Lines
// are written whole. A reader that has gone away ends the reports, not the run.
RunObserver json_observer(int descriptor, std::vector<double> expected_s = {});

// Error: bad-argument where the descriptor is not open for writing.
Result<void> check_progress_descriptor(int descriptor);

// Tells both.
RunObserver both(RunObserver first, RunObserver second);

}  // namespace sightline
