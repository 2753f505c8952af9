#pragma once

#include <cstddef>
#include <optional>

#include "formats/annotation/drive_tracks.h"
#include "formats/annotation/range_table.h"
#include "formats/drive/drive.h"
#include "passes/localize/drive_on_map.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_plan.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {

// What all replays of a drive share. `own` serves ranges, `of_samples` looks that take a sample.
struct TrackInputs {
  const DriveOnMap& placed;
  const RangeTable& ranges;
  const Localizer& own;
  const Localizer& of_samples;
  double leaf_m = 1.0;
  bool takes_every_return = false;  // within a range, as ScanCut says
};

// Every way to choose how to look that a map offers, and those that need none: its looks and its
// ranges, each everywhere.
std::vector<TrackRule> track_rules(const RangeTable& ranges);

// How one rule finds its vehicle, scan by scan. One thread at a time.
class TrackMatcher {
 public:
  // The rule is of the inputs' ranges.
  TrackMatcher(const TrackInputs& inputs, const TrackRule& rule);

  struct Found {
    MatchResult match;
    double range_m = 0.0;  // of the look that stands
    bool took_second = false;
  };
  // The map's answer is looked up at the predicted pose, as in a vehicle.
  Found match(const Scan& scan, const PosePrediction& prediction);

 private:
  [[nodiscard]] Look look_at(const Pose& T_map_vehicle) const;
  Found match_range(const Scan& scan, double range_m, const Pose& T_map_start);
  Found match_plan(const Scan& scan, const LookPlan& plan, const PosePrediction& prediction);

  TrackInputs inputs_;
  TrackRule rule_;
  std::size_t limit_ = 0;  // of the map, that the rule is served by
  ScanCutter cutter_;
  LookMemory memory_;
};

}  // namespace sightline
