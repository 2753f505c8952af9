#include "passes/model/choice/choices.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "passes/model/choice/floor.h"
#include "passes/model/choice/leave_one_drive_out.h"

// The rules of choose-ranges in their order; a later rule overrides the earlier ones. They are
// applied limit by limit, from the tightest limit to the loosest. By probability:
//
//   1  p* is calibrated on the model's own sites, separately for sites with measured history
//      (Calibrator). The promise is withdrawn if the model learnt from one place only and these
//      sites are in another.
//   2  Each site takes the cheapest look with P(error <= limit) >= p*. If there is none, it takes
//      the most probable look and is flagged kUnmet.
//   3  Sites whose look by rule 2 is extrapolated are flagged kExtrapolated. They take the static
//      answer (kStatic) if the option extrapolated_takes_static is set. The promise is withdrawn if
//      more than half of the sites are extrapolated.
//   4  Dilation: each site takes the longest range, or the dearest look, of the sites of its run
//      within dilation_m (3 m).
//   5a If two drives or more are known here and p* is controlled, the drives vote
//      (leave_one_drive_out.h). Sites with history are chosen again by rules 2 to 4, at the vote's
//      threshold, or all take one static answer; the other sites get rule 5b. The promise is
//      withdrawn if the vote replaces the promised rule by a cheaper, proven answer.
//   5b Otherwise the floor applies (floor.h). If the model was trained on simulated errors only,
//      ranges are chosen from what was simulated at each site. Otherwise all sites take one static
//      answer if the model is from too short a drive, explains nothing out of fold, or costs more
//      than a static answer that covers as much. The promise is withdrawn if the floor replaces the
//      choice.
//   6  A site looks no further than for the next tighter limit. The promise is withdrawn if this
//      shortens any range.
//   7  In a map without scans, sites where no drive was measured are flagged kSimulatedAnswer
//      (choose_ranges.cpp). The promise is withdrawn unless the model learnt from such maps.
//
// By mean: rule 2 takes the shortest range whose predicted mean error is within the limit, or else
// the longest, flagged kUnmet. Then rules 3, 6 and 7 apply. The mean rule makes no promise.

namespace sightline {
namespace {

// That a static answer must reach: what alpha leaves, where it controls anything.
double static_coverage(const ChooseRangesOptions& options, const LimitPromise& promise) {
  constexpr double kUncontrolled = 0.95;
  const bool is_controlled =
      options.selection == Selection::kProbability && options.risk_control != RiskControl::kFixed;
  return is_controlled ? 1.0 - promise.alpha : kUncontrolled;
}

// What is promised of a map of which some or all sites have measured history.
LimitPromise joined(const LimitPromise& map_only, const LimitPromise& history, bool everywhere) {
  LimitPromise promise = history;
  promise.probability_threshold = map_only.probability_threshold;
  if (everywhere) return promise;
  promise.is_earned = map_only.is_earned && history.is_earned;
  promise.alpha = std::max(map_only.alpha, history.alpha);
  promise.block_count = std::min(map_only.block_count, history.block_count);
  promise.place_count = std::min(map_only.place_count, history.place_count);
  promise.drive_count = std::min(map_only.drive_count, history.drive_count);
  promise.scope = std::min(map_only.scope, history.scope);
  promise.calibration_miss_share =
      std::max(map_only.calibration_miss_share, history.calibration_miss_share);
  promise.statement =
      "with measured history: " + history.statement + "; elsewhere: " + map_only.statement;
  return promise;
}

// Blocks of one place say how it varies within itself, not how the next place differs from it.
void withdraw_elsewhere(const PredictedError& predicted, LimitPromise& promise) {
  const auto own_count = std::ranges::count(predicted.out_of_fold, std::uint8_t{1});
  const bool is_elsewhere = own_count < std::ssize(predicted.out_of_fold);
  if (promise.place_count > 1 || !is_elsewhere || !promise.is_earned) return;
  promise.is_earned = false;
  promise.statement =
      "nothing is promised: the model learnt from one place alone, and these sites lie in another; "
      "train it on two or more";
}

// A promise is about places like those of the training; it says nothing where most sites are not.
void withdraw_where_unlike(const Choice& choice, LimitPromise& promise) {
  const auto unlike_count = std::ranges::count_if(
      choice.flags, [](std::uint8_t flags) { return (flags & kExtrapolated) != 0; });
  if (2 * unlike_count <= std::ssize(choice.flags) || !promise.is_earned) return;
  promise.is_earned = false;
  promise.statement =
      "nothing is promised: " + std::to_string(unlike_count) + " of " +
      std::to_string(choice.flags.size()) +
      " sites are unlike all that the model learnt from; train it on places, and with "
      "a sensor, like these";
}

// A static answer for a tighter limit may ask for less than the choice that a promise was made of.
void withdraw_where_capped(const Choice& before, const Choice& choice, LimitPromise& promise) {
  if (!promise.is_earned || before.range_index == choice.range_index) return;
  promise.is_earned = false;
  promise.statement =
      "nothing is promised: what is enough for a tighter limit by the map's own scans is less than "
      "what the model would promise";
}

double block_count_of(const Sites& sites) {
  constexpr double kBlock_m = 60.0;
  return std::floor(static_cast<double>(sites.sites.size()) * sites.spacing_m / kBlock_m);
}

// The floor, and what it makes of the promise.
void put_floor(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
               LimitPromise& promise, Choice& choice) {
  const Sites& sites = inputs.sites;
  const FloorOptions floor{
      .static_coverage = static_coverage(options, promise),
      .is_promised = promise.is_earned,
      .alpha = promise.alpha,
      .block_count = block_count_of(sites),
      .explained = explained_share(inputs.model),
      .is_too_short = inputs.model.card.fold_count == 0,
      .is_simulated = inputs.model.card.reference == ErrorReference::kSimulated};
  // A longer range costs far more, a dearer look little: of looks one is taken everywhere.
  const bool differs_by_place =
      floor.is_simulated && takes_every_return(inputs.evidence.looks.front());
  const std::optional<std::string> reason =
      differs_by_place ? take_simulated(inputs.evidence, promise.limit_m, floor.static_coverage,
                                        {route_of(sites), options.dilation_m}, choice)
                       : apply_floor(inputs.evidence, promise.limit_m, floor, choice);
  if (!reason) return;
  promise.is_earned = false;
  promise.statement = *reason;
}

// What predictions ask for at p*, `coverage` being what a static answer must reach.
Choice choose_at(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
                 const PredictedError& predicted, std::size_t limit, const Thresholds& thresholds,
                 double coverage) {
  Choice choice = choose_by_probability(predicted, limit, thresholds);
  mark_extrapolated(predicted, choice);
  if (options.extrapolated_takes_static) {
    refused_take_static(inputs.evidence, predicted.limits_m[limit], coverage, choice);
  }
  dilate(route_of(inputs.sites), options.dilation_m, choice);
  return choice;
}

// One limit's choice before the floor and what a tighter limit allows.
Choice choose_for_limit(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
                        std::size_t limit, LimitPromise& promise) {
  withdraw_elsewhere(inputs.predicted, promise);
  Choice choice = choose_at(options, inputs, inputs.predicted, limit,
                            {promise.probability_threshold, promise.history_threshold},
                            static_coverage(options, promise));
  withdraw_where_unlike(choice, promise);
  return choice;
}

std::optional<DriveVote> vote_of_drives(const ChooseRangesOptions& options,
                                        const ChoiceInputs& inputs, std::size_t limit,
                                        const LimitPromise& promise) {
  const bool is_controlled = options.risk_control != RiskControl::kFixed;
  if (!is_controlled || inputs.left_out.empty()) return std::nullopt;
  const DriveVoteOptions voting{.limit_m = promise.limit_m,
                                .coverage = static_coverage(options, promise),
                                .is_promised = promise.is_earned,
                                .threshold = promise.history_threshold,
                                .alpha = promise.alpha,
                                .block_count = block_count_of(inputs.sites)};
  return leave_one_drive_out(inputs.left_out, inputs.evidence, voting,
                             [&](const PredictedError& predicted, double threshold) {
                               return choose_at(options, inputs, predicted, limit,
                                                {promise.probability_threshold, threshold},
                                                voting.coverage);
                             });
}

// What the drives say holds where they were; elsewhere the floor does.
void take_vote(const ChooseRangesOptions& options, const ChoiceInputs& inputs, std::size_t limit,
               const DriveVote& vote, LimitPromise& promise, Choice& choice) {
  const std::vector<std::uint8_t>& has_history = inputs.predicted.has_history;
  Choice of_sites =
      choose_at(options, inputs, inputs.predicted, limit,
                {promise.probability_threshold, vote.threshold}, static_coverage(options, promise));
  if (std::ranges::count(has_history, std::uint8_t{0}) > 0) {
    put_floor(options, inputs, promise, choice);
  }
  for (std::size_t site = 0; site < has_history.size(); ++site) {
    if (has_history[site] == 0) continue;
    choice.range_index[site] = of_sites.range_index[site];
    choice.flags[site] = of_sites.flags[site];
    if (!vote.everywhere) continue;
    take_static(inputs.evidence, promise.limit_m, *vote.everywhere, site, choice);
  }
  promise.history_threshold = vote.threshold;
  if (promise.is_earned && !vote.keeps_promise) {
    promise.is_earned = false;
    promise.statement = "nothing is promised: another answer is cheaper and proven here";
  }
  promise.statement += "; " + to_text(vote, promise.limit_m);
}

}  // namespace

Chosen choose_all_by_mean(const ChooseRangesOptions& options, const ChoiceInputs& inputs) {
  const PredictedError& predicted = inputs.predicted;
  Chosen chosen;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    chosen.promises.push_back(assess_mean_rule(inputs.model, limit));
    const double limit_m = predicted.limits_m[limit];
    Choice choice = choose_by_mean(predicted, limit_m);
    mark_extrapolated(predicted, choice);
    if (options.extrapolated_takes_static) {
      refused_take_static(inputs.evidence, limit_m,
                          static_coverage(options, chosen.promises.back()), choice);
    }
    if (limit > 0) cap_by_tighter(chosen.choices.back(), choice);
    chosen.choices.push_back(std::move(choice));
  }
  return chosen;
}

Chosen choose_all_by_probability(const ChooseRangesOptions& options, const ChoiceInputs& inputs) {
  const PredictedError& predicted = inputs.predicted;
  const auto history_count = std::ranges::count(predicted.has_history, std::uint8_t{1});
  const bool everywhere = history_count == std::ssize(predicted.has_history);
  Calibrator calibrator(inputs.model, options);
  Chosen chosen;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    LimitPromise promise = calibrator.next(CaseKind::kMapOnly, limit);
    if (history_count > 0) {
      promise = joined(promise, calibrator.next(CaseKind::kHistory, limit), everywhere);
    }
    Choice choice = choose_for_limit(options, inputs, limit, promise);
    const std::optional<DriveVote> vote = vote_of_drives(options, inputs, limit, promise);
    if (vote) {
      take_vote(options, inputs, limit, *vote, promise, choice);
    } else {
      put_floor(options, inputs, promise, choice);
    }
    if (limit > 0) {
      const Choice uncapped = choice;
      cap_by_tighter(chosen.choices.back(), choice);
      withdraw_where_capped(uncapped, choice, promise);
    }
    chosen.promises.push_back(promise);
    chosen.choices.push_back(std::move(choice));
  }
  return chosen;
}

}  // namespace sightline
