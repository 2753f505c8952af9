#include "passes/model/choose_ranges.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "passes/model/calibration.h"
#include "passes/model/floor.h"
#include "passes/model/own_evidence.h"
#include "passes/model/selection.h"

namespace sightline {
namespace {

// A range is stored as one byte, in the table and in the map.
constexpr std::size_t kMostRanges = 255;

Result<void> check_inputs(const Sites& sites, const PredictedError& predicted,
                          const ErrorModel& model, const FactorTable& factors) {
  if (predicted.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found predictions of " + std::to_string(predicted.site_count) +
                     " sites, expected " + std::to_string(sites.sites.size()),
                 "", ""};
  }
  if (predicted.looks != model.out_of_fold.looks ||
      predicted.limits_m != model.out_of_fold.limits_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions and model are of different ranges or limits", "", ""};
  }
  if (factors.site_count != predicted.site_count || factors.looks != predicted.looks) {
    return Error{ErrorCode::kMismatchedInputs,
                 "factors and predictions are of different sites or ranges", "", ""};
  }
  const bool has_history = std::ranges::count(predicted.has_history, std::uint8_t{1}) > 0;
  if (has_history && !model.card.knows_history) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions use measured history, of which the model knows nothing", "", ""};
  }
  if (predicted.looks.size() > kMostRanges) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found " + std::to_string(predicted.looks.size()) + " ranges, expected at most " +
                     std::to_string(kMostRanges),
                 "", ""};
  }
  return {};
}

struct Chosen {
  std::vector<LimitPromise> promises;
  std::vector<Choice> choices;  // [limit], of the map's sites
};

// That a static answer must reach: what alpha leaves, where it controls anything.
double static_coverage(const ChooseRangesOptions& options) {
  constexpr double kUncontrolled = 0.95;
  const bool is_controlled =
      options.selection == Selection::kProbability && options.risk_control != RiskControl::kFixed;
  return is_controlled ? 1.0 - options.alpha : kUncontrolled;
}

// Whose errors the map's own scans tell: LocalizerKind's, PCL's apart.
bool is_of_this_program(const LocalizerProfile& localizer) {
  constexpr std::string_view kOurs[] = {"plain", "annealed", "searching"};
  return std::ranges::find(kOurs, localizer.name) != std::end(kOurs);
}

Chosen choose_all_by_mean(const ChooseRangesOptions& options, const PredictedError& predicted,
                          const ErrorModel& model, const OwnEvidence& evidence) {
  Chosen chosen;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    chosen.promises.push_back(assess_mean_rule(model, limit));
    const double limit_m = predicted.limits_m[limit];
    Choice choice = choose_by_mean(predicted, limit_m);
    mark_extrapolated(predicted, choice);
    if (options.extrapolated_takes_static) {
      refused_take_static(evidence, limit_m, static_coverage(options), choice);
    }
    if (limit > 0) cap_by_tighter(chosen.choices.back(), choice);
    chosen.choices.push_back(std::move(choice));
  }
  return chosen;
}

// What is promised of a map of which some or all sites have measured history.
LimitPromise joined(const LimitPromise& map_only, const LimitPromise& history, bool everywhere) {
  LimitPromise promise = history;
  promise.probability_threshold = map_only.probability_threshold;
  if (everywhere) return promise;
  promise.is_earned = map_only.is_earned && history.is_earned;
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

// Calibrates limit after limit, each capped by the choice for the tighter one before it.
class Calibrator {
 public:
  Calibrator(const ErrorModel& model, const ChooseRangesOptions& options)
      : model_(model),
        options_{options.risk_control, options.alpha, options.delta, options.probability_threshold,
                 options.dilation_m} {}

  LimitPromise next(CaseKind kind, std::size_t limit) {
    std::optional<Choice>& tighter = tighter_[static_cast<std::size_t>(kind)];
    Calibration calibration =
        calibrate_probability(model_, limit, kind, options_, tighter ? &*tighter : nullptr);
    tighter = std::move(calibration.choice);
    return calibration.promise;
  }

 private:
  const ErrorModel& model_;
  CalibrationOptions options_;
  std::optional<Choice> tighter_[2];  // of the model's sites, by kind
};

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
void put_floor(const ChooseRangesOptions& options, const ErrorModel& model,
               const OwnEvidence& evidence, LimitPromise& promise, Choice& choice) {
  const FloorOptions floor{static_coverage(options), promise.is_earned, explained_share(model),
                           model.card.fold_count == 0};
  const std::optional<std::string> reason = apply_floor(evidence, promise.limit_m, floor, choice);
  if (!reason) return;
  promise.is_earned = false;
  promise.statement = *reason;
}

// What choices are made of.
struct ChoiceInputs {
  const Sites& sites;
  const PredictedError& predicted;
  const ErrorModel& model;
  const OwnEvidence& evidence;
};

// One limit's choice before the floor and what a tighter limit allows.
Choice choose_for_limit(const ChooseRangesOptions& options, const ChoiceInputs& inputs,
                        std::size_t limit, LimitPromise& promise) {
  const PredictedError& predicted = inputs.predicted;
  withdraw_elsewhere(predicted, promise);
  Choice choice = choose_by_probability(predicted, limit,
                                        {promise.probability_threshold, promise.history_threshold});
  mark_extrapolated(predicted, choice);
  if (options.extrapolated_takes_static) {
    refused_take_static(inputs.evidence, predicted.limits_m[limit], static_coverage(options),
                        choice);
  }
  withdraw_where_unlike(choice, promise);
  dilate(route_of(inputs.sites), options.dilation_m, choice);
  return choice;
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
    put_floor(options, inputs.model, inputs.evidence, promise, choice);
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

RangeTable to_table(const PredictedError& predicted, Chosen chosen) {
  RangeTable table;
  table.looks = predicted.looks;
  table.site_count = predicted.site_count;
  for (std::size_t site = 0; site < predicted.site_count; ++site) {
    for (const Choice& choice : chosen.choices) {
      table.range_index.push_back(choice.range_index[site]);
      table.flags.push_back(choice.flags[site]);
    }
  }
  table.promises = std::move(chosen.promises);
  return table;
}

void warn_of_flags(const PassContext& ctx, const RangeTable& table) {
  for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
    std::size_t unmet_count = 0;
    for (std::size_t site = 0; site < table.site_count; ++site) {
      unmet_count += (table.flags_of(site, limit) & kUnmet) != 0 ? 1 : 0;
    }
    if (unmet_count == 0) continue;
    ctx.warn("no range is good enough for " + format_double(table.promises[limit].limit_m) +
             " m at " + std::to_string(unmet_count) + " of " + std::to_string(table.site_count) +
             " sites: they take the most probable one, and are flagged");
  }
}

void warn_of_static(const PassContext& ctx, const RangeTable& table) {
  for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
    bool is_static = table.site_count > 0;
    for (std::size_t site = 0; site < table.site_count; ++site) {
      is_static &= (table.flags_of(site, limit) & kStatic) != 0;
    }
    if (is_static) ctx.warn(table.promises[limit].statement);
  }
}

}  // namespace

std::vector<OptionField> option_fields(ChooseRangesOptions& options) {
  return {choice("selection", options.selection,
                 "rule: by probability with a promise, or by mean as the paper does",
                 {"mean", "probability"}),
          choice("risk_control", options.risk_control,
                 "what sets the probability that is asked for", risk_control_names()),
          number("alpha", options.alpha, "share of misses that is allowed", 0.0001, 0.5),
          number("delta", options.delta, "learn-then-test: how often the promise itself may fail",
                 0.0001, 0.5),
          number("probability_threshold", options.probability_threshold,
                 "the probability asked for where risk_control is fixed", 0.0, 1.0),
          number("dilation_m", options.dilation_m,
                 "a site looks as far as any neighbour within this, m", 0.0, 100.0),
          flag("extrapolated_takes_static", options.extrapolated_takes_static,
               "take what the map's own scans ask for where factors lie beyond what the model "
               "saw")};
}

std::vector<std::string> promises_of(const ChooseRangesOptions& options, const ErrorModel& model) {
  std::vector<std::string> statements;
  if (options.selection == Selection::kMean) return statements;
  Calibrator calibrator(model, options);
  for (std::size_t limit = 0; limit < model.out_of_fold.limits_m.size(); ++limit) {
    statements.push_back("map only: " + calibrator.next(CaseKind::kMapOnly, limit).statement);
    if (!model.card.knows_history) continue;
    statements.push_back("with measured history: " +
                         calibrator.next(CaseKind::kHistory, limit).statement);
  }
  return statements;
}

namespace {

// Of one table's looks.
Result<RangeTable> choose_own(PassContext& ctx, const ChooseRangesOptions& options,
                              const Sites& sites, const PredictedError& predicted,
                              const ErrorModel& model, const FactorTable& factors) {
  SIGHTLINE_TRY(check_inputs(sites, predicted, model, factors));
  SIGHTLINE_ASSIGN(OwnEvidence evidence, own_evidence_of(factors));
  if (!is_of_this_program(model.card.localizer)) {
    evidence = for_another_localizer(std::move(evidence));
  }
  add_measured(sites, predicted, model, evidence);
  const bool is_mean = options.selection == Selection::kMean;
  RangeTable table = to_table(
      predicted, is_mean ? choose_all_by_mean(options, predicted, model, evidence)
                         : choose_all_by_probability(options, {sites, predicted, model, evidence}));
  table.selection = options.selection;
  table.dilation_m = is_mean ? 0.0 : options.dilation_m;
  table.extrapolated_takes_static = options.extrapolated_takes_static;
  warn_of_flags(ctx, table);
  warn_of_static(ctx, table);
  return table;
}

}  // namespace

Result<RangeTable> choose_ranges(PassContext& ctx, const ChooseRangesOptions& options,
                                 const Sites& sites, const PredictedError& predicted,
                                 const ErrorModel& model, const FactorTable& factors) {
  SIGHTLINE_ASSIGN(RangeTable table, choose_own(ctx, options, sites, predicted, model, factors));
  if (predicted.of_samples.empty()) return table;
  if (model.of_samples.empty() || factors.of_samples.empty()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions tell of looks that take a sample, model or factors do not", "", ""};
  }
  SIGHTLINE_ASSIGN(RangeTable of_samples,
                   choose_own(ctx, options, sites, predicted.of_samples.front(),
                              model.of_samples.front(), factors.of_samples.front()));
  table.of_samples.push_back(std::move(of_samples));
  return table;
}

}  // namespace sightline
