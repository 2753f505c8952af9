#include "passes/model/judge/evaluate_ranges.h"

#include <algorithm>
#include <utility>

#include "passes/model/judge/evaluate_looks.h"
#include "passes/model/judge/evaluate_ranges_scores.h"
#include "passes/model/promise/selection.h"

namespace sightline {
namespace {

Result<void> check_inputs(const EvaluationInputs& inputs) {
  const std::size_t site_count = inputs.sites.sites.size();
  if (inputs.predicted.site_count != site_count || inputs.ranges.site_count != site_count ||
      inputs.judged.scan_of_site.size() != site_count) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("found predictions of ", inputs.predicted.site_count, ", ranges of ",
                        inputs.ranges.site_count, " and errors of ",
                        inputs.judged.scan_of_site.size(), " sites, expected ", site_count)};
  }
  bool have_same_limits = inputs.ranges.promises.size() == inputs.predicted.limits_m.size();
  for (std::size_t i = 0; have_same_limits && i < inputs.ranges.promises.size(); ++i) {
    have_same_limits = inputs.ranges.promises[i].limit_m == inputs.predicted.limits_m[i];
  }
  if (!have_same_limits || inputs.predicted.looks != inputs.ranges.looks ||
      inputs.judged.looks != inputs.ranges.looks) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions, ranges and errors are of different ranges or limits"};
  }
  if (inputs.judged_sites.empty()) {
    return Error{ErrorCode::kNoOverlap, concat("drive '", inputs.judged.drive,
                                               "' has no scan near any of ", site_count, " sites")};
  }
  return {};
}

Choice choose_static(const EvaluationInputs& inputs, std::size_t range) {
  return choose_everywhere(range, inputs.sites.sites.size());
}

Choice choose_as_map(const EvaluationInputs& inputs, std::size_t limit) {
  Choice choice = choose_static(inputs, 0);
  for (std::size_t site = 0; site < inputs.ranges.site_count; ++site) {
    choice.range_index[site] = static_cast<std::uint8_t>(inputs.ranges.range(site, limit));
    choice.flags[site] = inputs.ranges.flags_of(site, limit);
  }
  return choice;
}

Choice choose_with_dilation(const EvaluationInputs& inputs, const EvaluateRangesOptions& options,
                            std::size_t limit) {
  const bool has_own = inputs.ranges.selection == Selection::kProbability;
  const LimitPromise& promise = inputs.ranges.promises[limit];
  const double given = options.probability_threshold;
  const Thresholds thresholds =
      has_own ? Thresholds{promise.probability_threshold, promise.history_threshold}
              : Thresholds{given, given};
  Choice choice = choose_by_probability(inputs.predicted, limit, thresholds);
  dilate(route_of(inputs.sites), has_own ? inputs.ranges.dilation_m : options.dilation_m, choice);
  return choice;
}

Choice choose_knowing_the_error(const EvaluationInputs& inputs, std::size_t limit) {
  Choice choice = choose_static(inputs, inputs.longest());
  for (const std::size_t site : inputs.judged_sites) {
    std::size_t range = 0;
    const auto meets = [&](std::size_t r) {
      return inputs.judged.row(site, r).mean_m <= inputs.limit_m(limit);
    };
    while (range < inputs.longest() && !meets(range)) ++range;
    choice.range_index[site] = static_cast<std::uint8_t>(range);
    if (!meets(range)) choice.flags[site] = kUnmet;
  }
  return choice;
}

double coverage_of(const EvaluationInputs& inputs, std::size_t limit, const Choice& choice) {
  const auto meets = [&](std::size_t site) {
    return inputs.judged.row(site, choice.range_index[site]).mean_m <= inputs.limit_m(limit);
  };
  const auto met = std::count_if(inputs.judged_sites.begin(), inputs.judged_sites.end(), meets);
  return static_cast<double>(met) / static_cast<double>(inputs.judged_sites.size());
}

Choice choose_static_covering(const EvaluationInputs& inputs, std::size_t limit, double coverage) {
  for (std::size_t range = 0; range < inputs.longest(); ++range) {
    Choice choice = choose_static(inputs, range);
    if (coverage_of(inputs, limit, choice) >= coverage) return choice;
  }
  return choose_static(inputs, inputs.longest());
}

// In the order of Rule. `tighter`: the same for the next tighter limit; empty for the tightest.
std::vector<Choice> choices_at(const EvaluationInputs& inputs, const EvaluateRangesOptions& options,
                               std::size_t limit, const std::vector<Choice>& tighter) {
  const Choice as_map = choose_as_map(inputs, limit);
  Choice probability = choose_with_dilation(inputs, options, limit);
  if (!tighter.empty()) {
    cap_by_tighter(tighter[static_cast<std::size_t>(Rule::kProbability)], probability);
  }
  return {as_map,
          choose_by_mean(inputs.predicted, inputs.limit_m(limit)),
          std::move(probability),
          choose_static_covering(inputs, limit, coverage_of(inputs, limit, as_map)),
          choose_static(inputs, inputs.longest()),
          choose_knowing_the_error(inputs, limit)};
}

void record_sites(const EvaluationInputs& inputs, Evaluation& evaluation) {
  for (const std::size_t i : inputs.judged_sites) {
    const Site& site = inputs.sites.sites[i];
    evaluation.sites.push_back({static_cast<std::uint32_t>(i), site.run, site.s_m, site.p_map_m.x(),
                                site.p_map_m.y(), inputs.kinds[i]});
    evaluation.out_of_fold_count += inputs.predicted.out_of_fold[i];
    for (std::size_t range = 0; range <= inputs.longest(); ++range) {
      evaluation.error_m.push_back(inputs.judged.row(i, range).mean_m);
      evaluation.time_ms.push_back(inputs.judged.row(i, range).mean_time_ms);
    }
  }
}

}  // namespace

std::vector<OptionField> option_fields(EvaluateRangesOptions& options) {
  return {
      number("stretch_m", options.stretch_m, "length of the worst stretch that is reported, m", 1.0,
             100000.0),
      number("probability_threshold", options.probability_threshold,
             "required probability (p*) of the probability rule, where the map has none", 0.0, 1.0),
      number("dilation_m", options.dilation_m,
             "dilation of the probability rule where the map has none, m", 0.0, 100.0)};
}

Result<Evaluation> evaluate_ranges(PassContext& ctx, const EvaluateRangesOptions& options,
                                   const Sites& sites,
                                   const ByFamily<PredictedError>& all_predicted,
                                   const ByFamily<RangeTable>& choice,
                                   const ByFamily<StoredTable<FactorTable>>& all_factors,
                                   const ByFamily<MeasuredError>& measured) {
  const StoredTable<FactorTable>& factors = all_factors.ranges;
  const PredictedError& predicted = all_predicted.ranges;
  const RangeTable& ranges = choice.ranges;
  const MeasuredError& judged = measured.ranges;
  if (factors.row_count() != 0 && factors.row_count() != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs, concat("found factors of ", factors.row_count(),
                                                      " sites, expected ", sites.sites.size())};
  }
  SIGHTLINE_ASSIGN(std::vector<PlaceKind> kinds, place_kinds(sites, factors));
  EvaluationInputs inputs{options.stretch_m, sites, predicted, ranges, judged,
                          std::move(kinds),  {}};
  for (std::size_t site = 0; site < judged.scan_of_site.size(); ++site) {
    if (judged.scan_of_site[site] >= 0) inputs.judged_sites.push_back(site);
  }
  SIGHTLINE_TRY(check_inputs(inputs));
  Evaluation evaluation;
  evaluation.drive = judged.drive;
  evaluation.reference = judged.reference;
  evaluation.site_count = static_cast<std::uint32_t>(sites.sites.size());
  evaluation.stretch_m = options.stretch_m;
  evaluation.limits_m = predicted.limits_m;
  record_sites(inputs, evaluation);
  for (std::size_t range = 0; range < ranges.looks.size(); ++range) {
    evaluation.statics.push_back(score_static(inputs, range));
  }
  std::vector<Choice> choices;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    choices = choices_at(inputs, options, limit, choices);
    for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
      evaluation.rules.push_back(
          score_choice(inputs, inputs.limit_m(limit), static_cast<Rule>(rule), choices[rule]));
      append_kind_scores(inputs, inputs.limit_m(limit), static_cast<Rule>(rule), choices[rule],
                         evaluation.kinds);
      for (const std::size_t site : inputs.judged_sites) {
        evaluation.chosen_range_index.push_back(choices[rule].range_index[site]);
      }
    }
    append_reliability(inputs, limit, evaluation.reliability);
  }
  if (choice.samples && measured.samples) {
    SIGHTLINE_ASSIGN(evaluation.samples, evaluate_looks(*choice.samples, measured));
  }
  ctx.progress(1, 1);
  return evaluation;
}

}  // namespace sightline
