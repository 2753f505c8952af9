#include "passes/vehicle/look_matcher.h"

namespace sightline {

void LookMatcher::take(const Scan& scan, const Look& look) {
  scan_ = &scan;
  look_ = look;
  if (!takes_every_return(look)) return;
  cut_ = make_scan_for_match(matching_.own, near_cutter_, scan, matching_.sensor,
                             {look.range_m, matching_.leaf_m, matching_.takes_every_return});
}

MatchResult LookMatcher::match(const Pose& T_map_start) {
  if (takes_every_return(look_)) return localize(matching_.own, cut_, T_map_start);
  cutter_.cut(matching_.of_samples, *scan_, matching_.sensor, look_, T_map_start, cut_);
  const MatchOptions options{.stop_step_m = kSampleStop_m};
  return look_.mode == LookMode::kSettle
             ? settle(matching_.of_samples, cut_, T_map_start, options)
             : localize(matching_.of_samples, cut_, T_map_start, options);
}

}  // namespace sightline
