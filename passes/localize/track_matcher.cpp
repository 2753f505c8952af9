#include "passes/localize/track_matcher.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace sightline {
namespace {

// A look alone: whether it is a vehicle's that tracks or not.
LookPlan plan_of(const Look& look) {
  LookPlan plan;
  plan.first = plan.second = look;
  plan.doubt_above = std::numeric_limits<double>::infinity();
  return plan;
}

}  // namespace

std::vector<TrackRule> track_rules(const ByFamily<RangeTable>& ranges) {
  std::vector<TrackRule> rules;
  for (const LimitPromise& promise : ranges.ranges.promises) {
    rules.push_back({TrackChoice::kRange, promise.limit_m, {}});
  }
  if (const std::optional<RangeTable>& looks = ranges.samples) {
    for (const LimitPromise& promise : looks->promises) {
      rules.push_back({TrackChoice::kLook, promise.limit_m, {}});
    }
    for (const LimitPromise& promise : looks->promises) {
      if (!looks->plan || promise.limit_m < looks->plan->limit_m) continue;
      rules.push_back({TrackChoice::kPlan, promise.limit_m, {}});
    }
    for (const Look& look : looks->looks) rules.push_back({TrackChoice::kNobody, 0.0, look});
  }
  for (const Look& look : ranges.ranges.looks) rules.push_back({TrackChoice::kNobody, 0.0, look});
  return rules;
}

TrackMatcher::TrackMatcher(const TrackInputs& inputs, const TrackRule& rule)
    : inputs_(inputs), rule_(rule), memory_{LookCutter(inputs.leaf_m), {}} {
  const auto& promises = inputs.ranges.ranges.promises;
  const auto found = std::ranges::find(promises, rule.limit_m, &LimitPromise::limit_m);
  if (found != promises.end()) limit_ = static_cast<std::size_t>(found - promises.begin());
}

Look TrackMatcher::look_at(const Pose& T_map_vehicle) const {
  if (rule_.is_static()) return rule_.look;
  const bool is_range = rule_.choice == TrackChoice::kRange;
  const RangeTable& table = is_range ? inputs_.ranges.ranges : *inputs_.ranges.samples;
  const std::optional<std::size_t> site = inputs_.placed.site_near(T_map_vehicle);
  return site ? table.looks[table.range(*site, limit_)] : inputs_.ranges.ranges.looks.back();
}

TrackMatcher::Found TrackMatcher::match_range(const Scan& scan, double range_m,
                                              const Pose& T_map_start) {
  ScanForMatch cut = make_scan_for_match(inputs_.own, cutter_, scan, inputs_.placed.drive.sensor,
                                         {range_m, inputs_.leaf_m, inputs_.takes_every_return});
  return {localize(inputs_.own, cut, T_map_start), range_m, false};
}

TrackMatcher::Found TrackMatcher::match_plan(const Scan& scan, const LookPlan& plan,
                                             const PosePrediction& prediction) {
  const PlannedMatch found = localize_in_looks(
      {inputs_.of_samples, inputs_.placed.drive.sensor, plan}, scan, prediction, memory_);
  const bool took_second = found.look_count > 1;
  const Look& stands = took_second || !prediction.is_tracking ? plan.second : plan.first;
  return {found.match, stands.range_m, took_second};
}

TrackMatcher::Found TrackMatcher::match(const Scan& scan, const PosePrediction& prediction) {
  const bool has_plan = rule_.choice == TrackChoice::kPlan && prediction.is_tracking &&
                        inputs_.placed.site_near(prediction.T_map_vehicle).has_value();
  const Look look = look_at(prediction.T_map_vehicle);
  if (has_plan) {
    return match_plan(scan, plan_at(*inputs_.ranges.samples->plan, look), prediction);
  }
  if (takes_every_return(look)) return match_range(scan, look.range_m, prediction.T_map_vehicle);
  return match_plan(scan, plan_of(look), {prediction.T_map_vehicle, false});
}

}  // namespace sightline
