#include "passes/evaluate_ranges.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compiler/base/parallel.h"
#include "passes/learn/selection.h"

namespace sightline {
namespace {

// What all scores are worked out from.
struct Court {
  const EvaluateRangesOptions& options;
  const Sites& sites;
  const PredictedError& predicted;
  const RangeTable& ranges;
  const MeasuredError& judged;
  std::vector<std::size_t> judged_sites;  // that have a scan

  [[nodiscard]] std::size_t longest() const { return ranges.ranges_m.size() - 1; }
  [[nodiscard]] double limit_m(std::size_t limit) const { return predicted.limits_m[limit]; }
};

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

double mean_of(const std::vector<double>& values) {
  return ordered_sum(values) / static_cast<double>(values.size());
}

double max_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
}

Choice choose_static(const Court& court, std::size_t range) {
  const std::size_t site_count = court.sites.sites.size();
  Choice choice;
  choice.range_index.assign(site_count, static_cast<std::uint8_t>(range));
  choice.flags.assign(site_count, 0);
  return choice;
}

Choice choose_as_map(const Court& court, std::size_t limit) {
  const std::size_t limit_count = court.ranges.promises.size();
  Choice choice;
  for (std::size_t site = 0; site < court.ranges.site_count; ++site) {
    choice.range_index.push_back(court.ranges.range_index[site * limit_count + limit]);
    choice.flags.push_back(court.ranges.flags[site * limit_count + limit]);
  }
  return choice;
}

Choice choose_with_dilation(const Court& court, std::size_t limit) {
  const bool has_own = court.ranges.selection == Selection::kProbability;
  const LimitPromise& promise = court.ranges.promises[limit];
  const double given = court.options.probability_threshold;
  const Thresholds thresholds =
      has_own ? Thresholds{promise.probability_threshold, promise.history_threshold}
              : Thresholds{given, given};
  Choice choice = choose_by_probability(court.predicted, limit, thresholds);
  dilate(route_of(court.sites), has_own ? court.ranges.dilation_m : court.options.dilation_m,
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
std::vector<Choice> choices_at(const Court& court, std::size_t limit,
                               const std::vector<Choice>& tighter) {
  const Choice as_map = choose_as_map(court, limit);
  Choice probability = choose_with_dilation(court, limit);
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

void score_worst_stretch(const Court& court, const std::vector<double>& met, RuleScore& score) {
  const double sites_in_stretch = std::round(court.options.stretch_m / court.sites.spacing_m);
  const std::size_t length =
      std::clamp<std::size_t>(static_cast<std::size_t>(sites_in_stretch), 1, met.size());
  double met_count = 0.0;
  double least = static_cast<double>(length) + 1.0;
  for (std::size_t i = 0; i < met.size(); ++i) {
    met_count += met[i];
    if (i >= length) met_count -= met[i - length];
    if (i + 1 < length || met_count >= least) continue;
    least = met_count;
    score.worst_begin_site = static_cast<std::uint32_t>(court.judged_sites[i + 1 - length]);
  }
  score.worst_coverage = least / static_cast<double>(length);
}

RuleScore score_choice(const Court& court, double limit_m, Rule rule, const Choice& choice) {
  std::vector<double> met, errors, ranges, times, run_times, works, unmet, extrapolated;
  std::vector<double> longest_times, longest_works;
  for (const std::size_t site : court.judged_sites) {
    const ErrorRow& row = court.judged.row(site, choice.range_index[site]);
    const ErrorRow& longest = court.judged.row(site, court.longest());
    met.push_back(row.mean_m <= limit_m ? 1.0 : 0.0);
    errors.push_back(row.mean_m);
    ranges.push_back(court.ranges.ranges_m[choice.range_index[site]]);
    times.push_back(row.mean_time_ms);
    run_times.push_back(row.max_time_ms);
    works.push_back(row.mean_work);
    longest_times.push_back(longest.mean_time_ms);
    longest_works.push_back(longest.mean_work);
    unmet.push_back((choice.flags[site] & kUnmet) != 0 ? 1.0 : 0.0);
    extrapolated.push_back((choice.flags[site] & kExtrapolated) != 0 ? 1.0 : 0.0);
  }
  const auto ratio = [](const std::vector<double>& part, const std::vector<double>& whole) {
    const double sum = ordered_sum(whole);
    return sum > 0.0 ? ordered_sum(part) / sum : 0.0;
  };
  RuleScore score;
  score.limit_m = limit_m;
  score.rule = rule;
  score.coverage = mean_of(met);
  score.mean_error_m = mean_of(errors);
  score.p95_error_m = quantile(errors, 0.95);
  score.mean_range_m = mean_of(ranges);
  score.time_ratio = ratio(times, longest_times);
  score.work_ratio = ratio(works, longest_works);
  score.mean_time_ms = mean_of(times);
  score.max_site_time_ms = max_of(times);
  score.max_run_time_ms = max_of(run_times);
  score.unmet_share = mean_of(unmet);
  score.extrapolated_share = mean_of(extrapolated);
  score_worst_stretch(court, met, score);
  return score;
}

StaticScore score_static(const Court& court, std::size_t range) {
  std::vector<double> errors, times, run_times, works, residuals, deviations;
  for (const std::size_t site : court.judged_sites) {
    const ErrorRow& row = court.judged.row(site, range);
    const double residual = court.predicted.mean(site, range) - row.mean_m;
    errors.push_back(row.mean_m);
    times.push_back(row.mean_time_ms);
    run_times.push_back(row.max_time_ms);
    works.push_back(row.mean_work);
    residuals.push_back(residual * residual);
  }
  StaticScore score;
  score.range_m = court.ranges.ranges_m[range];
  score.mean_error_m = mean_of(errors);
  score.mean_time_ms = mean_of(times);
  score.max_site_time_ms = max_of(times);
  score.max_run_time_ms = max_of(run_times);
  score.mean_work = mean_of(works);
  for (const double error : errors) {
    deviations.push_back((error - score.mean_error_m) * (error - score.mean_error_m));
  }
  const double total = ordered_sum(deviations);
  score.r_squared = total > 0.0 ? 1.0 - ordered_sum(residuals) / total : 0.0;
  score.rmse_m = std::sqrt(mean_of(residuals));
  return score;
}

// Does what was promised 80 % of the time happen 80 % of the time?
void append_reliability(const Court& court, std::size_t limit,
                        std::vector<ReliabilityBin>& reliability) {
  constexpr std::size_t kBinCount = 10;
  std::vector<ReliabilityBin> bins(kBinCount);
  for (const std::size_t site : court.judged_sites) {
    for (std::size_t range = 0; range <= court.longest(); ++range) {
      const double promised = court.predicted.probability(site, range, limit);
      const auto tenth = static_cast<std::size_t>(promised * static_cast<double>(kBinCount));
      ReliabilityBin& bin = bins[std::min(tenth, kBinCount - 1)];
      bin.promised += promised;
      bin.observed += court.judged.row(site, range).mean_m <= court.limit_m(limit) ? 1.0 : 0.0;
      ++bin.count;
    }
  }
  for (ReliabilityBin& bin : bins) {
    if (bin.count == 0) continue;
    bin.limit_m = court.limit_m(limit);
    bin.promised /= static_cast<double>(bin.count);
    bin.observed /= static_cast<double>(bin.count);
    reliability.push_back(bin);
  }
}

void record_sites(const Court& court, Evaluation& evaluation) {
  for (const std::size_t i : court.judged_sites) {
    const Site& site = court.sites.sites[i];
    evaluation.sites.push_back(
        {static_cast<std::uint32_t>(i), site.run, site.s_m, site.p_map_m.x(), site.p_map_m.y()});
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
                                   const RangeTable& ranges, const MeasuredError& judged) {
  Court court{options, sites, predicted, ranges, judged, {}};
  for (std::size_t site = 0; site < judged.scan_of_site.size(); ++site) {
    if (judged.scan_of_site[site] >= 0) court.judged_sites.push_back(site);
  }
  const Result<void> checked = check_inputs(court);
  if (!checked) return checked.error();
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
    choices = choices_at(court, limit, choices);
    for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
      evaluation.rules.push_back(
          score_choice(court, court.limit_m(limit), static_cast<Rule>(rule), choices[rule]));
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
