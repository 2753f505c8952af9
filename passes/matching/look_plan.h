#pragma once

#include <cstddef>
#include <functional>

#include "formats/drive/drive.h"
#include "formats/drive/look.h"
#include "formats/geometry.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/matcher.h"

namespace sightline {

// Of a match of so many points that was started from the predicted pose. Finite for any match.
// Allocates nothing.
LookSigns look_signs(const MatchResult& match, std::size_t point_count,
                     const Pose& T_map_predicted);

// Where a vehicle takes itself to be, and from what.
struct PosePrediction {
  Pose T_map_vehicle = Pose::Identity();
  bool is_tracking = true;  // from its last two matches; else from outside, up to a metre off
};

// After `latest_ms` by the clock `now_ms` no further look begins. Without a clock there is none.
struct LookDeadline {
  std::function<double()> now_ms;
  double latest_ms = 0.0;
};

struct PlannedMatch {
  MatchResult match;              // what stands; its iterations and work are of all looks
  int look_count = 0;             // 1 or 2
  bool is_past_deadline = false;  // the second look was due and did not begin
  // Of the first look, where there was one: so that a test can be learnt.
  Pose T_map_first = Pose::Identity();
  LookSigns signs{};
  double doubt = 0.0;
};

// `plan` is valid.
struct PlannedLocalizer {
  const Localizer& localizer;  // made with options_for_samples()
  const SensorProfile& sensor;
  const LookPlan& plan;
  MatchOptions options = {.stop_step_m = kSampleStop_m};
};

// Kept for its memory alone. One thread at a time.
struct LookMemory {
  LookCutter cutter;
  ScanForMatch cut;
};

// The vehicle's pose in the map. A vehicle that tracks begins with the first look, whatever the
// clock says. Where the test doubts it, the second look begins at the predicted place, turned to
// the best of eleven headings up to 10 degrees off, since a vehicle that enters a bend turns as its
// last two poses do not predict. One that does not track takes the second look alone, and
// searches, whatever that look's mode is. A second look that finds nothing to match leaves the
// first one's pose. Deterministic but for the deadline; the same for every kernel. Allocates
// nothing once such scans were seen, unless a look takes every return.
PlannedMatch localize_in_looks(const PlannedLocalizer& planned, const Scan& scan,
                               const PosePrediction& prediction, LookMemory& memory,
                               const LookDeadline& deadline = {});

}  // namespace sightline
