#include <algorithm>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "compiler/gate/rules/shared_limits.h"
#include "compiler/gate/rules/stretches.h"

// Two maps: what became worse on the whole.

namespace sightline {
namespace {

// The change of one figure of the whole map at every limit that both have. `figure(map, limit)`;
// none: not judged.
template <class Figure>
std::vector<Found> each_change(const GateInput& input, const std::string& what,
                               std::string_view unit, const Figure& figure) {
  std::vector<Found> found;
  for (const SharedLimit& limit : shared_limits(input)) {
    const std::optional<double> now = figure(*input.map, limit.in_new);
    const std::optional<double> old = figure(*input.old_map, limit.in_old);
    if (!now || !old) {
      found.push_back({limit.limit_m, std::nullopt, 0.0,
                       "one of the maps holds no factor virtual_points", false});
      continue;
    }
    found.push_back({limit.limit_m, std::nullopt, *now - *old,
                     what + within(limit.limit_m) + " was " + in_words(*old, unit) + " and is " +
                         in_words(*now, unit)});
  }
  return found;
}

std::vector<Found> find_coverage_drop(const GateInput& input, const Threshold&) {
  std::vector<Found> found =
      each_change(input, "expected coverage", "share",
                  [](const CompiledMap& map, std::size_t limit) -> std::optional<double> {
                    return map.quality[limit].expected_coverage;
                  });
  for (Found& each : found) each.value = -each.value;  // what was lost
  return found;
}

// What was measured needs no model: it shows a change that the factors do not show.
std::vector<Found> find_measured_coverage_drop(const GateInput& input, const Threshold&) {
  if (input.map->measurement.measured_site_count == 0 ||
      input.old_map->measurement.measured_site_count == 0) {
    return {
        {std::nullopt, std::nullopt, 0.0, "one of the maps was not measured by a drive", false}};
  }
  std::vector<Found> found =
      each_change(input, "coverage measured by the drive that each map learnt from", "share",
                  [](const CompiledMap& map, std::size_t limit) -> std::optional<double> {
                    return map.quality[limit].measured_coverage;
                  });
  for (Found& each : found) each.value = -each.value;  // what was lost
  return found;
}

std::vector<Found> find_mean_range_rise(const GateInput& input, const Threshold&) {
  return each_change(input, "mean range", "m",
                     [](const CompiledMap& map, std::size_t limit) -> std::optional<double> {
                       return map.quality[limit].mean_range_m;
                     });
}

std::vector<Found> find_work_rise(const GateInput& input, const Threshold&) {
  return each_change(input, "the expected work of a match", "of the longest", expected_work);
}

std::vector<Found> find_unmet_rise(const GateInput& input, const Threshold&) {
  return each_change(input, "the share of sites where no range is good enough", "share",
                     [](const CompiledMap& map, std::size_t limit) -> std::optional<double> {
                       return map.quality[limit].unmet_count /
                              static_cast<double>(map.ranges.site_count);
                     });
}

std::vector<Found> find_extrapolated_rise(const GateInput& input, const Threshold&) {
  return each_change(input, "the share of sites unlike what the model was trained on", "share",
                     [](const CompiledMap& map, std::size_t limit) -> std::optional<double> {
                       return map.quality[limit].extrapolated_count /
                              static_cast<double>(map.ranges.site_count);
                     });
}

std::vector<Found> find_sharpness_loss(const GateInput& input, const Threshold&) {
  const bool is_same_drive =
      input.map->measurement.mapping_drive == input.old_map->measurement.mapping_drive;
  if (!input.map->sharpness || !input.old_map->sharpness || !is_same_drive) {
    return {{std::nullopt, std::nullopt, 0.0,
             "sharpness compares maps of one drive that both say how sharp they are", false}};
  }
  const double now = input.map->sharpness->of_map.mean_entropy_nat;
  const double old = input.old_map->sharpness->of_map.mean_entropy_nat;
  return {{std::nullopt, std::nullopt, now - old,
           "mean map entropy was " + in_words(old, "nat") + " and is " + in_words(now, "nat")}};
}

// Route of the old map that no site of the new one stands for.
std::vector<Found> find_route_lost(const GateInput& input, const Threshold& threshold) {
  std::vector<bool> is_lost;
  for (const auto& site : input.pairs.new_of_old) is_lost.push_back(!site.has_value());
  std::vector<Found> found;
  double longest_m = 0.0;
  for (const LongStretch& lost : long_stretches(input.old_map->sites, is_lost)) {
    // A single site stands for the route around it.
    const double length_m = lost.length_m + input.old_map->sites.spacing_m;
    longest_m = std::max(longest_m, length_m);
    if (length_m <= threshold.at(std::nullopt).value_or(0.0)) continue;
    RouteStretch place = stretch_between(input.old_map->sites, lost.first, lost.last);
    place.is_of_old = true;
    found.push_back(
        {std::nullopt, place, length_m,
         in_words(place) + ": " + in_words(length_m, "m") + " of route are not in the new map"});
  }
  if (!found.empty()) return found;
  return {{std::nullopt, std::nullopt, longest_m,
           longest_m == 0.0 ? "the new map holds all of the old map's route"
                            : "at most " + in_words(longest_m, "m") +
                                  " of the old map's route at a time are not in the new map"}};
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"coverage-drop", kOldMap, kError, kAtMost, 0.02, "share",
     "Fall of the expected coverage of the whole map", find_coverage_drop},
    {"measured-coverage-drop", kOldMap, kError, kAtMost, 0.03, "share",
     "Fall of the share of the measured sites whose error at the chosen range is within the limit, "
     "on the drive that each map learnt from",
     find_measured_coverage_drop},
    {"mean-range-rise", kOldMap, kError, kAtMost, 2.0, "m", "Rise of the mean range",
     find_mean_range_rise},
    {"work-rise", kOldMap, kError, kAtMost, 0.05, "of the longest",
     "Rise of the expected work (see expected-work)", find_work_rise},
    {"unmet-rise", kOldMap, kError, kAtMost, 0.02, "share",
     "Rise of the share of sites where no range is good enough", find_unmet_rise},
    {"extrapolated-rise", kOldMap, kError, kAtMost, 0.05, "share",
     "Rise of the share of sites unlike what the model was trained on", find_extrapolated_rise},
    {"sharpness-loss", kOldMap, kWarning, kAtMost, 0.05, "nat",
     "Rise of the mean map entropy, where both maps are of one drive", find_sharpness_loss},
    {"route-lost", kOldMap, kError, kAtMost, 20.0, "m",
     "Piece of the old map's route without a site of the new map within reach", find_route_lost},
};

}  // namespace

std::span<const GateRule> rules_of_change() { return kRules; }

}  // namespace sightline
