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
                       "the map has no promise" + within(limit.limit_m), false});
      continue;
    }
    const double promised = 1.0 - promise->alpha;
    found.push_back(
        {limit.limit_m, std::nullopt, promised - limit.answered_coverage,
         fmt::format("the promised coverage of the answered sites{} is {}, the observed one {}",
                     within(limit.limit_m), percent(promised), percent(limit.answered_coverage))});
  }
  return found;
}

// The last site of a stretch of this length that begins at a site.
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

const ObservedAnswer* answer_by(const std::vector<ObservedAnswer>& answers, std::string_view by,
                                double limit_m) {
  const auto found = std::ranges::find_if(answers, [&](const ObservedAnswer& answer) {
    return answer.by == by && answer.limit_m == limit_m;
  });
  return found == answers.end() ? nullptr : &*found;
}

// A rule about one kind of answer.
struct AnswerFigure {
  std::vector<ObservedAnswer> Observation::*answers;
  std::string_view by;
  double ObservedAnswer::*number;
  std::string_view unit;
  std::string_view words;    // as in observed()
  std::string_view missing;  // why there is no such answer: {0} is " within 0.1 m"
};

template <const AnswerFigure& kFigure>
std::vector<Found> of_answers(const GateInput& input, const Threshold&) {
  const Observation& observation = *input.observation;
  std::vector<Found> found;
  for (const ObservedLimit& limit : observation.limits) {
    const ObservedAnswer* answer =
        answer_by(observation.*kFigure.answers, kFigure.by, limit.limit_m);
    const std::string number =
        answer != nullptr ? in_words(answer->*kFigure.number, kFigure.unit) : "";
    found.push_back({limit.limit_m, std::nullopt, answer != nullptr ? answer->*kFigure.number : 0.0,
                     fmt::format(fmt::runtime(answer != nullptr ? kFigure.words : kFigure.missing),
                                 within(limit.limit_m), number, observation.drive),
                     answer != nullptr});
  }
  return found;
}

constexpr std::string_view kNoLooks = "the evaluation has no looks{0}";
constexpr std::string_view kNoPlan = "the evaluation has no replay by a plan{0}";

constexpr AnswerFigure kLookCoverage = {&Observation::looks,
                                        "look",
                                        &ObservedAnswer::coverage,
                                        "share",
                                        "on drive {2} the coverage of "
                                        "the looks{0} was {1}",
                                        kNoLooks};
constexpr AnswerFigure kLookTime = {&Observation::looks,
                                    "look",
                                    &ObservedAnswer::time_ratio,
                                    "of the longest",
                                    "matching by the looks{0} took {1} range's time",
                                    kNoLooks};
constexpr AnswerFigure kPlanCoverage = {&Observation::replayed,
                                        "plan",
                                        &ObservedAnswer::coverage,
                                        "share",
                                        "by the plan {1} of the scans of drive {2} were{0}",
                                        kNoPlan};
constexpr AnswerFigure kPlanTime = {&Observation::replayed,
                                    "plan",
                                    &ObservedAnswer::time_ratio,
                                    "of the longest",
                                    "matching by the plan{0} took {1} range's time",
                                    kNoPlan};

// By the first of plan, looks and ranges that was replayed at the limit.
std::vector<Found> find_lost_tracks(const GateInput& input, const Threshold&) {
  constexpr std::pair<std::string_view, std::string_view> kKinds[] = {
      {"plan", "plan"}, {"look", "looks"}, {"map", "ranges"}};
  const Observation& observation = *input.observation;
  if (observation.replayed.empty()) {
    return not_judged("the evaluation has no replay of the drive");
  }
  std::vector<Found> found;
  for (const ObservedLimit& limit : observation.limits) {
    for (const auto& [by, words] : kKinds) {
      const ObservedAnswer* answer = answer_by(observation.replayed, by, limit.limit_m);
      if (answer == nullptr) continue;
      found.push_back({limit.limit_m, std::nullopt, double{1} * answer->lost_count,
                       concat("localizing by the ", words, within(limit.limit_m), " lost ",
                              answer->lost_count, " tracks on drive ", observation.drive)});
      break;
    }
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
     "Promised minus observed coverage of the answered sites, where the map has a promise",
     find_broken_promise},
    {"observed-worst-stretch", kObservation, kError, kAtLeast, 0.50, "share",
     "Coverage observed on the worst stretch of route", find_worst_stretch},
    {"observed-work", kObservation, kWarning, kAtMost, 0.95, "of the longest",
     "Points x iterations at the chosen ranges, over those at the longest", find_work},
    {"observed-time", kObservation, kWarning, kAtMost, 1.0, "of the longest",
     "CPU time of a match at the chosen ranges, over that at the longest", find_time},
    {"observed-lost-tracks", kObservation, kWarning, kAtMost, 0.0, "tracks",
     "Tracks lost on the replayed drive by the plan, else by the looks, else by the ranges",
     find_lost_tracks},
    {"observed-look-coverage", kObservation, kError, kAtLeast, 0.80, "share",
     "Share of the judged sites of an independent drive within the limit, by the looks",
     &of_answers<kLookCoverage>},
    {"observed-look-time", kObservation, kWarning, kAtMost, 1.0, "of the longest",
     "CPU time of a match by the looks, over that at the longest range", &of_answers<kLookTime>},
    {"observed-plan-coverage", kObservation, kError, kAtLeast, 0.80, "share",
     "Share of the scans of the replayed drive within the limit, by the plan",
     &of_answers<kPlanCoverage>},
    {"observed-plan-time", kObservation, kWarning, kAtMost, 1.0, "of the longest",
     "CPU time of a match by the plan, over that at the longest range", &of_answers<kPlanTime>},
};

}  // namespace

std::span<const GateRule> rules_of_observation() { return kRules; }

}  // namespace sightline
