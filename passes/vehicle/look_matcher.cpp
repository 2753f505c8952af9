#include "passes/vehicle/look_matcher.h"

namespace sightline {

void LookMatcher::take(const Scan& scan, const Look& look) {
  look_ = look;
  climbs_.clear();
  if (!takes_every_return(look)) {
    cutter_.prepare(scan, look);
    if (!look.is_by_normals) {
      cutter_.finish(matching_.of_samples, matching_.sensor, Pose::Identity(), cut_);
    }
    return;
  }
  cut_ = make_scan_for_match(matching_.own, near_cutter_, scan, matching_.sensor,
                             {look.range_m, matching_.leaf_m, matching_.takes_every_return});
}

MatchResult LookMatcher::match(const Pose& T_map_start) {
  SharedClimbs* const shared = matching_.shares_climbs && !look_.is_by_normals ? &climbs_ : nullptr;
  if (takes_every_return(look_)) {
    return localize(matching_.own, cut_, T_map_start, {}, shared);
  }
  if (look_.is_by_normals) {
    cutter_.finish(matching_.of_samples, matching_.sensor, T_map_start, cut_);
  }
  const MatchOptions options{.stop_step_m = kSampleStop_m};
  return look_.mode == LookMode::kSettle
             ? settle(matching_.of_samples, cut_, T_map_start, options)
             : localize(matching_.of_samples, cut_, T_map_start, options, shared);
}

}  // namespace sightline
