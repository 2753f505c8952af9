#include "passes/model/choices.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "passes/model/floor.h"

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

// The floor, and what it makes of the promise.
void put_floor(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
               LimitPromise& promise, Choice& choice) {
  constexpr double kBlock_m = 60.0;
  const Sites& sites = inputs.sites;
  const FloorOptions floor{
      .static_coverage = static_coverage(options, promise),
      .is_promised = promise.is_earned,
      .alpha = promise.alpha,
      .block_count =
          std::floor(static_cast<double>(sites.sites.size()) * sites.spacing_m / kBlock_m),
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

// One limit's choice before the floor and what a tighter limit allows.
Choice choose_for_limit(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
                        std::size_t limit, LimitPromise& promise) {
  const PredictedError& predicted = inputs.predicted;
  withdraw_elsewhere(predicted, promise);
  Choice choice = choose_by_probability(predicted, limit,
                                        {promise.probability_threshold, promise.history_threshold});
  mark_extrapolated(predicted, choice);
  if (options.extrapolated_takes_static) {
    refused_take_static(inputs.evidence, predicted.limits_m[limit],
                        static_coverage(options, promise), choice);
  }
  withdraw_where_unlike(choice, promise);
  dilate(route_of(inputs.sites), options.dilation_m, choice);
  return choice;
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
    put_floor(options, inputs, promise, choice);
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
