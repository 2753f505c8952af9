#include <algorithm>
#include <limits>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "compiler/gate/rules/shared_limits.h"
#include "compiler/gate/rules/stretches.h"
#include "formats/base/parallel.h"

// Two maps: where it became worse.

namespace sightline {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// What a rule asks of each site of the new map, beside its place in the old one.
struct ChangeRule {
  std::string what;           // "the range"
  std::string_view unit;      // of before and after
  double sign = 1.0;          // +1: a rise is bad, -1: a fall
  bool is_in_limits = false;  // the change is a share of the limit
};

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

Found tell_change(const GateInput& input, const ChangeRule& rule, const ChangeOfSites& change,
                  double limit_m, const BadStretch& stretch) {
  const RouteStretch place = stretch_between(input.map->sites, stretch.first, stretch.last);
  const std::string_view unit = rule.is_in_limits ? "of the limit" : rule.unit;
  return {limit_m, place, stretch.worst,
          in_words(place) + ": " + rule.what + within(limit_m) + " was " +
              in_words(mean_between(change.before, stretch), rule.unit) + " and is " +
              in_words(mean_between(change.after, stretch), rule.unit) + " over the worst " +
              format_double(input.change_stretch_m) + " m of route, " +
              in_words(stretch.worst, unit) + (rule.sign > 0.0 ? " more" : " less")};
}

// Every stretch where the change is too large; where there is none, the worst one.
void find_stretches(const GateInput& input, const ChangeRule& rule, const ChangeOfSites& change,
                    std::pair<double, std::optional<double>> limit_and_allowed,
                    std::vector<Found>& found) {
  const auto& [limit_m, allowed] = limit_and_allowed;
  const double scale = rule.sign / (rule.is_in_limits ? limit_m : 1.0);
  std::vector<double> worse;
  for (std::size_t i = 0; i < change.after.size(); ++i) {
    worse.push_back(scale * (change.after[i] - change.before[i]));
  }
  const StretchSearch search{input.change_stretch_m, Bound::kAtMost};
  std::vector<BadStretch> bad;
  if (allowed) bad = bad_stretches(input.map->sites, worse, search, *allowed);
  if (bad.empty()) bad.push_back(worst_stretch(input.map->sites, worse, search));
  for (const BadStretch& stretch : bad) {
    if (stretch.last < stretch.first) {
      found.push_back({limit_m, std::nullopt, 0.0, "the maps share no route", false});
    } else {
      found.push_back(tell_change(input, rule, change, limit_m, stretch));
    }
  }
}

// `numbers(limit, new site, old site)`: the number in the old map and in the new one.
template <class Numbers>
std::vector<Found> each_stretch_change(const GateInput& input, const Threshold& threshold,
                                       const ChangeRule& rule, const Numbers& numbers) {
  std::vector<Found> found;
  for (const SharedLimit& limit : shared_limits(input)) {
    ChangeOfSites change;
    for (std::size_t site = 0; site < input.map->sites.sites.size(); ++site) {
      const std::optional<std::uint32_t>& old = input.pairs.old_of_new[site];
      const auto [before, after] =
          old ? numbers(limit, site, *old) : std::pair<double, double>(kNone, kNone);
      change.before.push_back(before);
      change.after.push_back(after);
    }
    find_stretches(input, rule, change, {limit.limit_m, threshold.at(limit.limit_m)}, found);
  }
  return found;
}

std::vector<Found> find_range_rise(const GateInput& input, const Threshold& threshold) {
  return each_stretch_change(
      input, threshold, {"the range", "m"},
      [&](const SharedLimit& limit, std::size_t now, std::size_t old) -> std::pair<double, double> {
        return {input.old_map->ranges.range_m(old, limit.in_old),
                input.map->ranges.range_m(now, limit.in_new)};
      });
}

double chosen_probability(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const std::size_t range = map.ranges.range(site, limit);
  return map.predicted.probability(site, range, limit);
}

std::vector<Found> find_stretch_coverage_drop(const GateInput& input, const Threshold& threshold) {
  return each_stretch_change(
      input, threshold, {"expected coverage", "share", -1.0},
      [&](const SharedLimit& limit, std::size_t now, std::size_t old) -> std::pair<double, double> {
        return {chosen_probability(*input.old_map, old, limit.in_old),
                chosen_probability(*input.map, now, limit.in_new)};
      });
}

// The range of the new map that is the old one's choice, or the next longer one.
std::size_t same_range(const CompiledMap& map, double range_m) {
  const auto found = std::ranges::lower_bound(map.ranges.looks, range_m, {}, &Look::range_m);
  const std::size_t longest = map.ranges.looks.size() - 1;
  return std::min(static_cast<std::size_t>(found - map.ranges.looks.begin()), longest);
}

std::vector<Found> find_error_rise(const GateInput& input, const Threshold& threshold) {
  return each_stretch_change(
      input, threshold, {"the error expected at the old map's range", "m", 1.0, true},
      [&](const SharedLimit& limit, std::size_t now, std::size_t old) -> std::pair<double, double> {
        const double range_m = input.old_map->ranges.range_m(old, limit.in_old);
        return {input.old_map->predicted.mean(old, same_range(*input.old_map, range_m)),
                input.map->predicted.mean(now, same_range(*input.map, range_m))};
      });
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
    const double allowed_m = threshold.at(limit.limit_m).value_or(0.0);
    double longest_m = 0.0;
    const std::size_t told_before = found.size();
    for (const LongStretch& stretch : long_stretches(input.map->sites, is_new)) {
      const double length_m = stretch.length_m + input.map->sites.spacing_m;
      longest_m = std::max(longest_m, length_m);
      if (length_m <= allowed_m) continue;
      const RouteStretch place = stretch_between(input.map->sites, stretch.first, stretch.last);
      found.push_back({limit.limit_m, place, length_m,
                       in_words(place) + ": where some range was good enough" +
                           within(limit.limit_m) + ", now none is, for " + in_words(length_m, "m") +
                           " of route"});
    }
    if (found.size() > told_before) continue;
    found.push_back({limit.limit_m, std::nullopt, longest_m,
                     "at most " + in_words(longest_m, "m") +
                         " of route at a time lost every range good enough" +
                         within(limit.limit_m)});
  }
  return found;
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"stretch-error-rise", kOldMap, kError, kAtMost, 0.25, "of the limit",
     "Rise of the error expected at the old map's chosen range, over the limit, mean over "
     "`change_stretch_m` of route",
     find_error_rise},
    {"stretch-range-rise", kOldMap, kError, kAtMost, 5.0, "m",
     "Rise of the chosen range, mean over `change_stretch_m` of route", find_range_rise},
    {"stretch-coverage-drop", kOldMap, kError, kAtMost, 0.10, "share",
     "Fall of P(error <= limit) at the chosen range, mean over `change_stretch_m` of route",
     find_stretch_coverage_drop},
    {"stretch-unmet", kOldMap, kError, kAtMost, 10.0, "m",
     "Piece of route where some range was good enough and none is now", find_newly_unmet},
};

}  // namespace

std::span<const GateRule> rules_of_stretches() { return kRules; }

}  // namespace sightline
