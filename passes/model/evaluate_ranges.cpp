#include "passes/model/evaluate_ranges.h"

#include <algorithm>
#include <utility>

#include "passes/model/evaluate_ranges_scores.h"
#include "passes/model/selection.h"

namespace sightline {
namespace {

Result<void> check_inputs(const Court& court) {
  const std::size_t site_count = court.sites.sites.size();
  if (court.predicted.site_count != site_count || court.ranges.site_count != site_count ||
      court.judged.scan_of_site.size() != site_count) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found predictions of " + std::to_string(court.predicted.site_count) +
                     ", ranges of " + std::to_string(court.ranges.site_count) + " and errors of " +
                     std::to_string(court.judged.scan_of_site.size()) + " sites, expected " +
                     std::to_string(site_count),
                 "", ""};
  }
  bool have_same_limits = court.ranges.promises.size() == court.predicted.limits_m.size();
  for (std::size_t i = 0; have_same_limits && i < court.ranges.promises.size(); ++i) {
    have_same_limits = court.ranges.promises[i].limit_m == court.predicted.limits_m[i];
  }
  if (!have_same_limits || court.predicted.ranges_m != court.ranges.ranges_m ||
      court.judged.ranges_m != court.ranges.ranges_m) {
    return Error{ErrorCode::kMismatchedInputs,
                 "predictions, ranges and errors are of different ranges or limits", "", ""};
  }
  if (court.judged_sites.empty()) {
    return Error{ErrorCode::kNoOverlap,
                 "drive '" + court.judged.drive + "' has no scan near any of " +
                     std::to_string(site_count) + " sites",
                 "", ""};
  }
  return {};
}

Choice choose_static(const Court& court, std::size_t range) {
  const std::size_t site_count = court.sites.sites.size();
  Choice choice;
  choice.range_index.assign(site_count, static_cast<std::uint8_t>(range));
  choice.flags.assign(site_count, 0);
  return choice;
}

Choice choose_as_map(const Court& court, std::size_t limit) {
  Choice choice;
  for (std::size_t site = 0; site < court.ranges.site_count; ++site) {
    choice.range_index.push_back(static_cast<std::uint8_t>(court.ranges.range(site, limit)));
    choice.flags.push_back(court.ranges.flags_of(site, limit));
  }
  return choice;
}

Choice choose_with_dilation(const Court& court, const EvaluateRangesOptions& options,
                            std::size_t limit) {
  const bool has_own = court.ranges.selection == Selection::kProbability;
  const LimitPromise& promise = court.ranges.promises[limit];
  const double given = options.probability_threshold;
  const Thresholds thresholds =
      has_own ? Thresholds{promise.probability_threshold, promise.history_threshold}
              : Thresholds{given, given};
  Choice choice = choose_by_probability(court.predicted, limit, thresholds);
  dilate(route_of(court.sites), has_own ? court.ranges.dilation_m : options.dilation_m,
         choice);
  return choice;
}

Choice choose_knowing_the_error(const Court& court, std::size_t limit) {
  Choice choice = choose_static(court, court.longest());
  for (const std::size_t site : court.judged_sites) {
    std::size_t range = 0;
    const auto meets = [&](std::size_t r) {
      return court.judged.row(site, r).mean_m <= court.limit_m(limit);
    };
    while (range < court.longest() && !meets(range)) ++range;
    choice.range_index[site] = static_cast<std::uint8_t>(range);
    if (!meets(range)) choice.flags[site] = kUnmet;
  }
  return choice;
}

double coverage_of(const Court& court, std::size_t limit, const Choice& choice) {
  const auto meets = [&](std::size_t site) {
    return court.judged.row(site, choice.range_index[site]).mean_m <= court.limit_m(limit);
  };
  const auto met = std::count_if(court.judged_sites.begin(), court.judged_sites.end(), meets);
  return static_cast<double>(met) / static_cast<double>(court.judged_sites.size());
}

Choice choose_static_covering(const Court& court, std::size_t limit, double coverage) {
  for (std::size_t range = 0; range < court.longest(); ++range) {
    Choice choice = choose_static(court, range);
    if (coverage_of(court, limit, choice) >= coverage) return choice;
  }
  return choose_static(court, court.longest());
}

// In the order of Rule. `tighter`: the same for the next tighter limit; empty for the tightest.
std::vector<Choice> choices_at(const Court& court, const EvaluateRangesOptions& options, std::size_t limit,
                               const std::vector<Choice>& tighter) {
  const Choice as_map = choose_as_map(court, limit);
  Choice probability = choose_with_dilation(court, options, limit);
  if (!tighter.empty()) {
    cap_by_tighter(tighter[static_cast<std::size_t>(Rule::kProbability)], probability);
  }
  return {as_map,
          choose_by_mean(court.predicted, court.limit_m(limit)),
          std::move(probability),
          choose_static_covering(court, limit, coverage_of(court, limit, as_map)),
          choose_static(court, court.longest()),
          choose_knowing_the_error(court, limit)};
}

void record_sites(const Court& court, Evaluation& evaluation) {
  for (const std::size_t i : court.judged_sites) {
    const Site& site = court.sites.sites[i];
    evaluation.sites.push_back(
        {static_cast<std::uint32_t>(i), site.run, site.s_m, site.p_map_m.x(), site.p_map_m.y(),
         court.streets[i]});
    evaluation.out_of_fold_count += court.predicted.out_of_fold[i];
    for (std::size_t range = 0; range <= court.longest(); ++range) {
      evaluation.error_m.push_back(court.judged.row(i, range).mean_m);
      evaluation.time_ms.push_back(court.judged.row(i, range).mean_time_ms);
    }
  }
}

}  // namespace

std::vector<OptionField> option_fields(EvaluateRangesOptions& options) {
  return {number("stretch_m", options.stretch_m, "route of which the worst is reported, m", 1.0,
                 100000.0),
          number("probability_threshold", options.probability_threshold,
                 "p* of the probability rule where the map has none", 0.0, 1.0),
          number("dilation_m", options.dilation_m,
                 "dilation of the probability rule where the map has none, m", 0.0, 100.0)};
}

Result<Evaluation> evaluate_ranges(PassContext& ctx, const EvaluateRangesOptions& options,
                                   const Sites& sites, const PredictedError& predicted,
                                   const RangeTable& ranges, const FactorTable& factors,
                                   const MeasuredError& judged) {
  if (factors.site_count != 0 && factors.site_count != sites.sites.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 "found factors of " + std::to_string(factors.site_count) + " sites, expected " +
                     std::to_string(sites.sites.size()),
                 "", ""};
  }
  Court court{options.stretch_m, sites, predicted, ranges, judged, street_types(factors), {}};
  court.streets.resize(sites.sites.size(), StreetType::kUnknown);  // a map stripped of factors
  for (std::size_t site = 0; site < judged.scan_of_site.size(); ++site) {
    if (judged.scan_of_site[site] >= 0) court.judged_sites.push_back(site);
  }
  SIGHTLINE_TRY(check_inputs(court));
  Evaluation evaluation;
  evaluation.drive = judged.drive;
  evaluation.reference = judged.reference;
  evaluation.site_count = static_cast<std::uint32_t>(sites.sites.size());
  evaluation.stretch_m = options.stretch_m;
  evaluation.limits_m = predicted.limits_m;
  record_sites(court, evaluation);
  for (std::size_t range = 0; range < ranges.ranges_m.size(); ++range) {
    evaluation.statics.push_back(score_static(court, range));
  }
  std::vector<Choice> choices;
  for (std::size_t limit = 0; limit < predicted.limits_m.size(); ++limit) {
    choices = choices_at(court, options, limit, choices);
    for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
      evaluation.rules.push_back(
          score_choice(court, court.limit_m(limit), static_cast<Rule>(rule), choices[rule]));
      append_street_scores(court, court.limit_m(limit), static_cast<Rule>(rule), choices[rule],
                           evaluation.streets);
      for (const std::size_t site : court.judged_sites) {
        evaluation.chosen_range_index.push_back(choices[rule].range_index[site]);
      }
    }
    append_reliability(court, limit, evaluation.reliability);
  }
  ctx.progress(1, 1);
  return evaluation;
}

}  // namespace sightline
