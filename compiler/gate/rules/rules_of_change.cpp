#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "formats/base/parallel.h"

// Two maps: what became worse on the whole, and where.

namespace sightline {
namespace {

// A limit that both maps have, and which of theirs it is.
struct SharedLimit {
  double limit_m = 0.0;
  std::size_t in_new = 0;
  std::size_t in_old = 0;
};

std::vector<SharedLimit> shared_limits(const GateInput& input) {
  std::vector<SharedLimit> shared;
  const std::vector<double>& now_m = input.map->predicted.limits_m;
  const std::vector<double>& old_m = input.old_map->predicted.limits_m;
  for (std::size_t i = 0; i < now_m.size(); ++i) {
    const auto found = std::ranges::find(old_m, now_m[i]);
    if (found == old_m.end()) continue;
    shared.push_back({now_m[i], i, static_cast<std::size_t>(found - old_m.begin())});
  }
  return shared;
}

constexpr LimitFigure kMeasuredCoverage = {
    "coverage on the localization drive of each map", "share",
    [](const CompiledMap& map, std::size_t limit) { return map.quality[limit].measured_coverage; }};

// By how much a figure rose (kSign -1: fell) at every limit that both maps have.
template <const LimitFigure& kFigure, int kSign = 1>
std::vector<Found> change(const GateInput& input, const Threshold&) {
  std::vector<Found> found;
  for (const SharedLimit& limit : shared_limits(input)) {
    const double now = kFigure.of(*input.map, limit.in_new);
    const double old = kFigure.of(*input.old_map, limit.in_old);
    if (std::isnan(now) || std::isnan(old)) {
      found.push_back({limit.limit_m, std::nullopt, 0.0,
                       "one of the maps has no factor virtual_points", false});
      continue;
    }
    found.push_back({limit.limit_m, std::nullopt, kSign * (now - old),
                     fmt::format("{}{} was {} and is {}", kFigure.what, within(limit.limit_m),
                                 in_words(old, kFigure.unit), in_words(now, kFigure.unit))});
  }
  return found;
}

// Measured errors need no model: they show a change that the factors do not show.
std::vector<Found> find_measured_coverage_drop(const GateInput& input, const Threshold& threshold) {
  if (input.map->measurement.measured_site_count == 0 ||
      input.old_map->measurement.measured_site_count == 0) {
    return not_judged("no drive was measured in one of the maps");
  }
  return change<kMeasuredCoverage, -1>(input, threshold);
}

std::vector<Found> find_sharpness_loss(const GateInput& input, const Threshold&) {
  const bool is_same_drive =
      input.map->measurement.mapping_drive == input.old_map->measurement.mapping_drive;
  if (!input.map->sharpness || !input.old_map->sharpness || !is_same_drive) {
    return not_judged("sharpness is compared where both maps have it and are of one drive");
  }
  const double now = input.map->sharpness->of_map.mean_entropy_nat;
  const double old = input.old_map->sharpness->of_map.mean_entropy_nat;
  return of_whole_map(now - old, concat("mean map entropy was ", in_words(old, "nat"), " and is ",
                                        in_words(now, "nat")));
}

// Before and after, at a site of the new map and its place in the old one.
using Numbers = std::pair<double, double> (*)(const GateInput& input, const SharedLimit& limit,
                                              std::size_t now, std::size_t old);

struct SiteChange {
  std::string_view what;  // "the range"
  std::string_view unit;  // of before and after
  Numbers numbers;
  double sign = 1.0;          // +1: a rise is bad, -1: a fall
  bool is_in_limits = false;  // the change is a share of the limit
};

constexpr SiteChange kRangeRise = {
    "the range", "m",
    [](const GateInput& input, const SharedLimit& limit, std::size_t now, std::size_t old) {
      return std::pair(input.old_map->ranges.range_m(old, limit.in_old),
                       input.map->ranges.range_m(now, limit.in_new));
    }};

constexpr SiteChange kCoverageDrop = {
    "expected coverage", "share",
    [](const GateInput& input, const SharedLimit& limit, std::size_t now, std::size_t old) {
      return std::pair(chosen_probability(*input.old_map, old, limit.in_old),
                       chosen_probability(*input.map, now, limit.in_new));
    },
    -1.0};

// At the range of each map that is the old one's choice, or the next longer one.
double error_at(const CompiledMap& map, std::size_t site, double range_m) {
  const auto found = std::ranges::lower_bound(map.ranges.looks, range_m, {}, &Look::range_m);
  const std::size_t longest = map.ranges.looks.size() - 1;
  return map.predicted.mean(
      site, std::min(static_cast<std::size_t>(found - map.ranges.looks.begin()), longest));
}

constexpr SiteChange kErrorRise = {
    "the predicted error at the old map's range", "m",
    [](const GateInput& input, const SharedLimit& limit, std::size_t now, std::size_t old) {
      const double range_m = input.old_map->ranges.range_m(old, limit.in_old);
      return std::pair(error_at(*input.old_map, old, range_m), error_at(*input.map, now, range_m));
    },
    1.0, true};

struct ChangeOfSites {
  std::vector<double> before;  // [site of the new map]; NaN where the old map has none
  std::vector<double> after;
};

double mean_between(const std::vector<double>& values, const BadStretch& stretch) {
  const auto begin = values.begin() + static_cast<long>(stretch.worst_first);
  const auto end = values.begin() + static_cast<long>(stretch.worst_last) + 1;
  const std::vector<double> part(begin, end);
  return ordered_sum(part) / static_cast<double>(part.size());
}

Found found_at(const GateInput& input, const SiteChange& rule, const ChangeOfSites& change,
               double limit_m, const BadStretch& stretch) {
  if (stretch.last < stretch.first) {
    return {limit_m, std::nullopt, 0.0, "the maps share no route", false};
  }
  const RouteStretch place = stretch_between(input.map->sites, stretch.first, stretch.last);
  return {limit_m, place, stretch.worst,
          fmt::format("{}: {}{} was {} and is {} over the worst {} m of route, {} {}",
                      in_words(place), rule.what, within(limit_m),
                      in_words(mean_between(change.before, stretch), rule.unit),
                      in_words(mean_between(change.after, stretch), rule.unit),
                      format_double(input.change_stretch_m),
                      in_words(stretch.worst, rule.is_in_limits ? "of the limit" : rule.unit),
                      rule.sign > 0.0 ? "more" : "less")};
}

// NaN where the old map has no such place.
ChangeOfSites change_of_sites(const GateInput& input, const SiteChange& rule,
                              const SharedLimit& limit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  ChangeOfSites change;
  for (std::size_t site = 0; site < input.map->sites.sites.size(); ++site) {
    const std::optional<std::uint32_t>& old = input.pairs.old_of_new[site];
    const auto [before, after] =
        old ? rule.numbers(input, limit, site, *old) : std::pair(kNone, kNone);
    change.before.push_back(before);
    change.after.push_back(after);
  }
  return change;
}

// Every stretch where the change is too large; where there is none, the worst one.
template <const SiteChange& kRule>
std::vector<Found> stretch_change(const GateInput& input, const Threshold& threshold) {
  std::vector<Found> found;
  for (const SharedLimit& limit : shared_limits(input)) {
    const ChangeOfSites change = change_of_sites(input, kRule, limit);
    const double scale = kRule.sign / (kRule.is_in_limits ? limit.limit_m : 1.0);
    std::vector<double> worse;
    for (std::size_t i = 0; i < change.after.size(); ++i) {
      worse.push_back(scale * (change.after[i] - change.before[i]));
    }
    for (const BadStretch& stretch :
         bad_or_worst(input.map->sites, worse, {input.change_stretch_m, Bound::kAtMost},
                      threshold.at(limit.limit_m))) {
      found.push_back(found_at(input, kRule, change, limit.limit_m, stretch));
    }
  }
  return found;
}

// Calls `use(place, length_m)` for every piece of bad sites that is longer than allowed (0 where
// no bound is set) and returns the longest length. A single site counts as the route around it.
template <class Use>
double each_long_piece(const Sites& sites, const std::vector<bool>& is_bad,
                       std::optional<double> allowed_m, const Use& use) {
  double longest_m = 0.0;
  for (const LongStretch& piece : long_stretches(sites, is_bad)) {
    const double length_m = piece.length_m + sites.spacing_m;
    longest_m = std::max(longest_m, length_m);
    if (length_m > allowed_m.value_or(0.0)) {
      use(stretch_between(sites, piece.first, piece.last), length_m);
    }
  }
  return longest_m;
}

std::vector<Found> find_newly_unmet(const GateInput& input, const Threshold& threshold) {
  std::vector<Found> found;
  for (const SharedLimit& limit : shared_limits(input)) {
    const std::vector<bool> now = unmet_sites(*input.map, limit.in_new);
    const std::vector<bool> old = unmet_sites(*input.old_map, limit.in_old);
    std::vector<bool> is_new;
    for (std::size_t site = 0; site < now.size(); ++site) {
      const std::optional<std::uint32_t>& before = input.pairs.old_of_new[site];
      is_new.push_back(now[site] && before && !old[*before]);
    }
    const std::size_t before = found.size();
    const double longest_m = each_long_piece(
        input.map->sites, is_new, threshold.at(limit.limit_m),
        [&](const RouteStretch& place, double length_m) {
          found.push_back(
              {limit.limit_m, place, length_m,
               fmt::format("{}: no range is good enough{} any more, for {} of route",
                           in_words(place), within(limit.limit_m), in_words(length_m, "m"))});
        });
    if (found.size() > before) continue;
    found.push_back({limit.limit_m, std::nullopt, longest_m,
                     concat("the longest route where no range is good enough any more",
                            within(limit.limit_m), " is ", in_words(longest_m, "m"))});
  }
  return found;
}

// Route of the old map without a site of the new one.
std::vector<Found> find_route_lost(const GateInput& input, const Threshold& threshold) {
  std::vector<bool> is_lost;
  for (const auto& site : input.pairs.new_of_old) is_lost.push_back(!site.has_value());
  std::vector<Found> found;
  const double longest_m =
      each_long_piece(input.old_map->sites, is_lost, threshold.at(std::nullopt),
                      [&](RouteStretch place, double length_m) {
                        place.is_of_old = true;
                        found.push_back({std::nullopt, place, length_m,
                                         concat(in_words(place), ": ", in_words(length_m, "m"),
                                                " of route are not in the new map")});
                      });
  if (!found.empty()) return found;
  return of_whole_map(longest_m,
                      longest_m == 0.0
                          ? "the new map contains all of the old map's route"
                          : concat("the longest piece of the old map's route that is not in "
                                   "the new map is ",
                                   in_words(longest_m, "m")));
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"stretch-error-rise", kOldMap, kError, kAtMost, 0.25, "of the limit",
     "Rise of the predicted error at the old map's chosen range, over the limit, mean over "
     "`change_stretch_m` of route",
     &stretch_change<kErrorRise>},
    {"stretch-range-rise", kOldMap, kError, kAtMost, 5.0, "m",
     "Rise of the chosen range, mean over `change_stretch_m` of route",
     &stretch_change<kRangeRise>},
    {"stretch-coverage-drop", kOldMap, kError, kAtMost, 0.10, "share",
     "Fall of P(error <= limit) at the chosen range, mean over `change_stretch_m` of route",
     &stretch_change<kCoverageDrop>},
    {"stretch-unmet", kOldMap, kError, kAtMost, 10.0, "m",
     "Piece of route where some range was good enough and none is now", find_newly_unmet},
    {"coverage-drop", kOldMap, kError, kAtMost, 0.02, "share",
     "Fall of the expected coverage of the whole map", &change<kExpectedCoverage, -1>},
    {"measured-coverage-drop", kOldMap, kError, kAtMost, 0.03, "share",
     "Fall of the share of the measured sites whose error at the chosen range is within the limit, "
     "on the localization drive of each map",
     find_measured_coverage_drop},
    {"mean-range-rise", kOldMap, kError, kAtMost, 2.0, "m", "Rise of the mean range",
     &change<kMeanRange>},
    {"work-rise", kOldMap, kError, kAtMost, 0.05, "of the longest",
     "Rise of the expected work (see expected-work)", &change<kExpectedWork>},
    {"unmet-rise", kOldMap, kError, kAtMost, 0.02, "share",
     "Rise of the share of sites where no range is good enough", &change<kUnmetShare>},
    {"extrapolated-rise", kOldMap, kError, kAtMost, 0.05, "share",
     "Rise of the share of sites unlike those that the model was trained on",
     &change<kExtrapolatedShare>},
    {"sharpness-loss", kOldMap, kWarning, kAtMost, 0.05, "nat",
     "Rise of the mean map entropy, where both maps are of one drive", find_sharpness_loss},
    {"route-lost", kOldMap, kError, kAtMost, 20.0, "m",
     "Piece of the old map's route without a site of the new map within reach", find_route_lost},
};

}  // namespace

std::span<const GateRule> rules_of_change() { return kRules; }

}  // namespace sightline
