#pragma once

#include <cstddef>

#include "formats/drive/drive.h"
#include "formats/drive/look.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"

namespace sightline {

// How scans are cut and matched by all code that localizes by looks.
struct LookMatching {
  const Localizer& own;         // for looks that take every return
  const Localizer& of_samples;  // for the others
  const SensorProfile& sensor;
  double leaf_m = 1.0;
  bool takes_every_return = false;  // within a range, as ScanCut says
  // Starts of one scan take over what earlier ones found, where the cut does not depend on them.
  bool shares_climbs = false;
};

// Localizes one scan after the other: what measure-error measures and what a vehicle does, so that
// a map's errors are the vehicle's own. One thread at a time. What `matching` refers to outlives
// it.
class LookMatcher {
 public:
  explicit LookMatcher(const LookMatching& matching)
      : matching_(matching), cutter_(matching.leaf_m) {}

  // The scan to be matched next, cut as far as no start changes it. What a look takes of it may
  // depend on the start: then match() cuts the rest.
  void take(const Scan& scan, const Look& look);

  // Of the scan taken last; T_map_sensor is the vehicle's pose.
  MatchResult match(const Pose& T_map_start);

  // Of the last match.
  [[nodiscard]] std::size_t point_count() const { return cut_.points_m.size(); }
  [[nodiscard]] double taken_over_ms() const { return climbs_.taken_over_ms(); }  // SharedClimbs'

 private:
  LookMatching matching_;
  ScanCutter near_cutter_;
  LookCutter cutter_;
  ScanForMatch cut_;
  SharedClimbs climbs_;  // of this cut
  Look look_;
};

}  // namespace sightline
