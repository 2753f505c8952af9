#include <fmt/format.h>

#include <algorithm>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

// A number of every limit. `words`: {0} is " within 0.1 m", {1} the number, {2} the drive.
std::vector<Found> observed(const GateInput& input, double ObservedLimit::*number,
                            std::string_view unit, std::string_view words) {
  std::vector<Found> found;
  for (const ObservedLimit& limit : input.observation->limits) {
    found.push_back({limit.limit_m, std::nullopt, limit.*number,
                     fmt::format(fmt::runtime(words), within(limit.limit_m),
                                 in_words(limit.*number, unit), input.observation->drive)});
  }
  return found;
}

std::vector<Found> find_coverage(const GateInput& input, const Threshold&) {
  return observed(input, &ObservedLimit::coverage, "share", "on drive {2} the coverage{0} was {1}");
}

std::vector<Found> find_time(const GateInput& input, const Threshold&) {
  return observed(input, &ObservedLimit::time_ratio, "of the longest",
                  "matching{0} took {1} range's time");
}

std::vector<Found> find_work(const GateInput& input, const Threshold&) {
  return observed(input, &ObservedLimit::work_ratio, "of the longest",
                  "matching{0} took {1} range's work");
}

std::vector<Found> find_broken_promise(const GateInput& input, const Threshold&) {
  const std::vector<LimitPromise>& promises = input.map->ranges.promises;
  std::vector<Found> found;
  for (const ObservedLimit& limit : input.observation->limits) {
    const auto promise = std::ranges::find(promises, limit.limit_m, &LimitPromise::limit_m);
    if (promise == promises.end() || !promise->is_earned) {
      found.push_back({limit.limit_m, std::nullopt, 0.0,
                       "nothing was promised" + within(limit.limit_m), false});
      continue;
    }
    const double promised = 1.0 - promise->alpha;
    found.push_back(
        {limit.limit_m, std::nullopt, promised - limit.coverage,
         fmt::format("coverage{} was promised as {} and observed as {}", within(limit.limit_m),
                     percent(promised), percent(limit.coverage))});
  }
  return found;
}

// The last site of the stretch that begins at a site: so much further along its run.
std::size_t end_of(const Sites& sites, std::size_t first, double length_m) {
  std::size_t last = first;
  while (last + 1 < sites.sites.size() && sites.sites[last + 1].run == sites.sites[first].run &&
         sites.sites[last + 1].s_m - sites.sites[first].s_m < length_m) {
    ++last;
  }
  return last;
}

std::vector<Found> find_worst_stretch(const GateInput& input, const Threshold&) {
  std::vector<Found> found;
  const Sites& sites = input.map->sites;
  for (const ObservedLimit& limit : input.observation->limits) {
    const RouteStretch place =
        stretch_between(sites, limit.worst_begin_site,
                        end_of(sites, limit.worst_begin_site, input.observation->stretch_m));
    found.push_back({limit.limit_m, place, limit.worst_coverage,
                     fmt::format("{}: the coverage{} on drive {} was {}", in_words(place),
                                 within(limit.limit_m), input.observation->drive,
                                 percent(limit.worst_coverage))});
  }
  return found;
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"observed-coverage", kObservation, kError, kAtLeast, 0.80, "share",
     "Share of the judged sites of an independent drive within the limit", find_coverage},
    {"observed-promise", kObservation, kError, kAtMost, 0.02, "share",
     "By how much the coverage observed falls short of an earned promise", find_broken_promise},
    {"observed-worst-stretch", kObservation, kError, kAtLeast, 0.50, "share",
     "Coverage observed on the worst stretch of route", find_worst_stretch},
    {"observed-work", kObservation, kWarning, kAtMost, 0.95, "of the longest",
     "Points x iterations at the chosen ranges, over those at the longest", find_work},
    {"observed-time", kObservation, kWarning, kAtMost, 1.0, "of the longest",
     "CPU time of a match at the chosen ranges, over that at the longest", find_time},
};

}  // namespace

std::span<const GateRule> rules_of_observation() { return kRules; }

}  // namespace sightline
