#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "compiler/gate/rules/stretches.h"

namespace sightline {
namespace {

// One finding for each limit of the map, of the number that `value` gives for its index.
template <class Value>
std::vector<Found> each_limit(const CompiledMap& map, const std::string& what,
                              std::string_view unit, const Value& value) {
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    const double limit_m = map.ranges.promises[limit].limit_m;
    const double number = value(limit);
    found.push_back(
        {limit_m, std::nullopt, number, what + within(limit_m) + " is " + in_words(number, unit)});
  }
  return found;
}

double share_of_sites(const CompiledMap& map, std::uint32_t count) {
  return static_cast<double>(count) / static_cast<double>(map.ranges.site_count);
}

std::vector<Found> find_promise(const GateInput& input, const Threshold&) {
  std::vector<Found> found;
  for (const LimitPromise& promise : input.map->ranges.promises) {
    const double value = promise.is_earned ? 1.0 : 0.0;
    found.push_back({promise.limit_m, std::nullopt, value,
                     std::string("the promise") + within(promise.limit_m) + " is " +
                         (promise.is_earned ? "earned: " : "not earned: ") + promise.statement});
  }
  return found;
}

std::vector<Found> find_expected_coverage(const GateInput& input, const Threshold&) {
  return each_limit(*input.map, "expected coverage", "share",
                    [&](std::size_t l) { return input.map->quality[l].expected_coverage; });
}

std::vector<Found> find_measured_coverage(const GateInput& input, const Threshold&) {
  if (input.map->measurement.measured_site_count == 0) {
    return {{std::nullopt, std::nullopt, 0.0, "no drive was measured in this map", false}};
  }
  return each_limit(*input.map, "coverage of the drive that the map learnt from", "share",
                    [&](std::size_t l) { return input.map->quality[l].measured_coverage; });
}

std::vector<Found> find_measured_sites(const GateInput& input, const Threshold&) {
  const double share = share_of_sites(*input.map, input.map->measurement.measured_site_count);
  return {{std::nullopt, std::nullopt, share,
           "errors were measured at " + in_words(share, "share") + " of the sites"}};
}

std::vector<Found> find_unmet_share(const GateInput& input, const Threshold&) {
  const CompiledMap& map = *input.map;
  return each_limit(map, "the share of sites where no range is good enough", "share",
                    [&](std::size_t l) { return share_of_sites(map, map.quality[l].unmet_count); });
}

std::vector<Found> find_extrapolated_share(const GateInput& input, const Threshold&) {
  const CompiledMap& map = *input.map;
  return each_limit(
      map, "the share of sites unlike what the model was trained on", "share",
      [&](std::size_t l) { return share_of_sites(map, map.quality[l].extrapolated_count); });
}

std::vector<Found> find_mean_range(const GateInput& input, const Threshold&) {
  return each_limit(*input.map, "mean range", "m",
                    [&](std::size_t l) { return input.map->quality[l].mean_range_m; });
}

std::vector<Found> find_p95_range(const GateInput& input, const Threshold&) {
  return each_limit(*input.map, "the range that covers 95 % of the sites", "m",
                    [&](std::size_t l) { return p95_range_m(*input.map, l); });
}

std::vector<Found> find_expected_work(const GateInput& input, const Threshold&) {
  if (!has_virtual_points(*input.map)) {
    return {{std::nullopt, std::nullopt, 0.0,
             "the map holds no factor virtual_points, by which work is predicted", false}};
  }
  return each_limit(*input.map, "the expected work of a match", "of the longest",
                    [&](std::size_t l) { return *expected_work(*input.map, l); });
}

// The worst stretch where none is bad, else each bad one.
std::vector<Found> find_worst_stretch(const GateInput& input, const Threshold& threshold) {
  const Sites& sites = input.map->sites;
  const StretchSearch search{input.stretch_m, Bound::kAtLeast};
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < input.map->ranges.promises.size(); ++limit) {
    const double limit_m = input.map->ranges.promises[limit].limit_m;
    const std::vector<double> value = chosen_probabilities(*input.map, limit);
    const auto tell = [&](std::size_t first, std::size_t last, double worst) {
      const RouteStretch place = stretch_between(sites, first, last);
      found.push_back({limit_m, place, worst,
                       in_words(place) + ": expected coverage" + within(limit_m) + " is " +
                           in_words(worst, "share") + " over the worst " +
                           format_double(input.stretch_m) + " m of route"});
    };
    const double allowed = threshold.at(limit_m).value_or(0.0);
    for (const BadStretch& bad : bad_stretches(sites, value, search, allowed)) {
      tell(bad.first, bad.last, bad.worst);
    }
    if (!found.empty() && found.back().limit_m == limit_m) continue;
    const BadStretch worst = worst_stretch(sites, value, search);
    tell(worst.first, worst.last, worst.worst);
  }
  return found;
}

std::vector<Found> find_unmet_stretch(const GateInput& input, const Threshold& threshold) {
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < input.map->ranges.promises.size(); ++limit) {
    const double limit_m = input.map->ranges.promises[limit].limit_m;
    std::vector<LongStretch> stretches =
        long_stretches(input.map->sites, unmet_sites(*input.map, limit));
    const auto tell = [&](const LongStretch& stretch) {
      const RouteStretch place = stretch_between(input.map->sites, stretch.first, stretch.last);
      found.push_back({limit_m, place, stretch.length_m,
                       in_words(place) + ": no range is good enough" + within(limit_m) + " for " +
                           in_words(stretch.length_m, "m") + " of route"});
    };
    const double allowed = threshold.at(limit_m).value_or(std::numeric_limits<double>::infinity());
    const std::size_t before = found.size();
    for (const LongStretch& stretch : stretches) {
      if (stretch.length_m > allowed) tell(stretch);
    }
    if (found.size() > before) continue;
    const auto longest = std::ranges::max_element(stretches, {}, &LongStretch::length_m);
    if (longest != stretches.end()) {
      tell(*longest);
    } else {
      found.push_back({limit_m, std::nullopt, 0.0,
                       "some range is good enough" + within(limit_m) + " at every site"});
    }
  }
  return found;
}

std::vector<Found> find_model_r_squared(const GateInput& input, const Threshold&) {
  const double mean = input.map->model.mean_r_squared;
  return {{std::nullopt, std::nullopt, mean,
           "the model's R^2 at places that it never saw is " + in_words(mean, "") +
               ", mean over ranges"}};
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"expected-coverage", kMap, kError, kAtLeast, 0.80, "share",
     "Mean over the sites of P(error <= limit) at the chosen range", find_expected_coverage},
    {"measured-coverage", kMap, kWarning, kAtLeast, 0.80, "share",
     "Share of the measured sites whose error at the chosen range is within the limit, on the "
     "drive that the map learnt from",
     find_measured_coverage},
    {"worst-stretch", kMap, kError, kAtLeast, 0.50, "share",
     "Expected coverage of the worst piece of route, `stretch_m` long", find_worst_stretch},
    {"promise-earned", kMap, kWarning, kAtLeast, 1.0, "",
     "Something is promised about the next drive (1) or not (0): the threshold was set on enough "
     "route, by drives that the model did not learn from",
     find_promise},
    {"unmet-share", kMap, kError, kAtMost, 0.50, "share",
     "Share of sites where no range is good enough", find_unmet_share},
    {"unmet-stretch", kMap, kWarning, kAtMost, 100.0, "m",
     "Longest piece of route without any site where some range is good enough", find_unmet_stretch},
    {"mean-range", kMap, kError, kAtMost, std::nullopt, "m", "Mean chosen range", find_mean_range},
    {"p95-range", kMap, kError, kAtMost, std::nullopt, "m",
     "The least range that 95 % of the sites stay within", find_p95_range},
    {"expected-work", kMap, kWarning, kAtMost, 0.95, "of the longest",
     "Sum over the sites of the factor virtual_points at the chosen range, over that at the "
     "longest: what matching is expected to cost",
     find_expected_work},
    {"extrapolated-share", kMap, kError, kAtMost, 0.25, "share",
     "Model support: share of sites that are unlike what the model was trained on",
     find_extrapolated_share},
    {"model-r-squared", kMap, kWarning, kAtLeast, 0.0, "",
     "Mean over ranges of the model's R^2 at places that it never saw", find_model_r_squared},
    {"measured-sites", kMap, kWarning, kAtLeast, 0.50, "share",
     "Share of sites where a scan of the localization drive was matched", find_measured_sites},
};

}  // namespace

std::span<const GateRule> rules_of_map() { return kRules; }

}  // namespace sightline
