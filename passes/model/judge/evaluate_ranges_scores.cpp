#include "passes/model/judge/evaluate_ranges_scores.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"

namespace sightline {
namespace {

// What a choice gave at some sites, one number a site.
struct Outcomes {
  std::vector<double> met, errors, ranges, times, run_times, works, unmet, extrapolated;
  std::vector<double> longest_times, longest_works;
  std::vector<double> answered_missed;  // of answered sites alone
  std::vector<double> truly_unmet;      // of the others: the longest range misses too
};

Outcomes outcomes_of(const EvaluationInputs& inputs, double limit_m, const Choice& choice,
                     const std::vector<std::size_t>& sites) {
  Outcomes out;
  for (const std::size_t site : sites) {
    const ErrorRow& row = inputs.judged.row(site, choice.range_index[site]);
    const ErrorRow& longest = inputs.judged.row(site, inputs.longest());
    out.met.push_back(row.mean_m <= limit_m ? 1.0 : 0.0);
    out.errors.push_back(row.mean_m);
    out.ranges.push_back(inputs.ranges.looks[choice.range_index[site]].range_m);
    out.times.push_back(row.mean_time_ms);
    out.run_times.push_back(row.max_time_ms);
    out.works.push_back(row.mean_work);
    out.longest_times.push_back(longest.mean_time_ms);
    out.longest_works.push_back(longest.mean_work);
    out.unmet.push_back(choice.is_answered(site) ? 0.0 : 1.0);
    if (choice.is_answered(site)) {
      out.answered_missed.push_back(1.0 - out.met.back());
    } else {
      out.truly_unmet.push_back(longest.mean_m > limit_m ? 1.0 : 0.0);
    }
    out.extrapolated.push_back((choice.flags[site] & kExtrapolated) != 0 ? 1.0 : 0.0);
  }
  return out;
}

double ratio(const std::vector<double>& part, const std::vector<double>& whole) {
  const double sum = ordered_sum(whole);
  return sum > 0.0 ? ordered_sum(part) / sum : 0.0;
}

double p95(std::vector<double> values) {
  std::ranges::sort(values);
  return quantile_of_sorted(values, 0.95);
}

// Judged sites [first, last) of one run.
struct JudgedRun {
  std::size_t first = 0;
  std::size_t last = 0;

  [[nodiscard]] std::size_t size() const { return last - first; }
};

std::vector<JudgedRun> judged_runs(const EvaluationInputs& inputs) {
  std::vector<JudgedRun> runs;
  const auto run_of = [&](std::size_t i) { return inputs.sites.sites[inputs.judged_sites[i]].run; };
  for (std::size_t i = 0; i < inputs.judged_sites.size(); ++i) {
    if (i == 0 || run_of(i) != run_of(i - 1)) runs.push_back({i, i});
    runs.back().last = i + 1;
  }
  return runs;
}

// A run with fewer judged sites than a stretch has says little: it counts only where all are so.
void score_worst_stretch(const EvaluationInputs& inputs, const std::vector<double>& met,
                         RuleScore& score) {
  const std::vector<JudgedRun> runs = judged_runs(inputs);
  const std::size_t longest = std::ranges::max(runs, {}, &JudgedRun::size).size();
  const double sites_in_stretch = std::round(inputs.stretch_m / inputs.sites.spacing_m);
  const std::size_t length =
      std::clamp<std::size_t>(static_cast<std::size_t>(sites_in_stretch), 1, longest);
  double least = static_cast<double>(length) + 1.0;
  for (const JudgedRun& run : runs) {
    double met_count = 0.0;
    for (std::size_t i = run.first; i < run.last; ++i) {
      met_count += met[i];
      if (i >= run.first + length) met_count -= met[i - length];
      if (i + 1 < run.first + length || met_count >= least) continue;
      least = met_count;
      score.worst_begin_site = static_cast<std::uint32_t>(inputs.judged_sites[i + 1 - length]);
      score.worst_end_site = static_cast<std::uint32_t>(inputs.judged_sites[i]);
    }
  }
  score.worst_coverage = least / static_cast<double>(length);
}

}  // namespace

RuleScore score_choice(const EvaluationInputs& inputs, double limit_m, Rule rule,
                       const Choice& choice) {
  const Outcomes out = outcomes_of(inputs, limit_m, choice, inputs.judged_sites);
  RuleScore score;
  score.limit_m = limit_m;
  score.rule = rule;
  score.coverage = mean_of(out.met);
  score.mean_error_m = mean_of(out.errors);
  score.p95_error_m = p95(out.errors);
  score.mean_range_m = mean_of(out.ranges);
  score.time_ratio = ratio(out.times, out.longest_times);
  score.work_ratio = ratio(out.works, out.longest_works);
  score.mean_time_ms = mean_of(out.times);
  score.max_site_time_ms = std::ranges::max(out.times);
  score.max_run_time_ms = std::ranges::max(out.run_times);
  score.unmet_share = mean_of(out.unmet);
  score.extrapolated_share = mean_of(out.extrapolated);
  if (!out.answered_missed.empty()) score.answered_miss_share = mean_of(out.answered_missed);
  if (!out.truly_unmet.empty()) score.truly_unmet_share = mean_of(out.truly_unmet);
  score_worst_stretch(inputs, out.met, score);
  return score;
}

void append_kind_scores(const EvaluationInputs& inputs, double limit_m, Rule rule,
                        const Choice& choice, std::vector<KindScore>& kinds) {
  for (std::size_t type = 1; type < kPlaceKindCount; ++type) {
    KindScore score;
    score.limit_m = limit_m;
    score.rule = rule;
    score.kind = static_cast<PlaceKind>(type);
    std::vector<std::size_t> sites;
    std::ranges::copy_if(inputs.judged_sites, std::back_inserter(sites),
                         [&](std::size_t site) { return inputs.kinds[site] == score.kind; });
    if (sites.empty()) continue;
    const Outcomes out = outcomes_of(inputs, limit_m, choice, sites);
    score.site_count = static_cast<std::uint32_t>(sites.size());
    score.site_share =
        static_cast<double>(sites.size()) / static_cast<double>(inputs.judged_sites.size());
    score.coverage = mean_of(out.met);
    score.mean_error_m = mean_of(out.errors);
    score.p95_error_m = p95(out.errors);
    score.mean_range_m = mean_of(out.ranges);
    score.time_ratio = ratio(out.times, out.longest_times);
    score.work_ratio = ratio(out.works, out.longest_works);
    kinds.push_back(score);
  }
}

StaticScore score_static(const EvaluationInputs& inputs, std::size_t range) {
  std::vector<double> errors, times, run_times, works, residuals, deviations;
  for (const std::size_t site : inputs.judged_sites) {
    const ErrorRow& row = inputs.judged.row(site, range);
    const double residual = inputs.predicted.mean(site, range) - row.mean_m;
    errors.push_back(row.mean_m);
    times.push_back(row.mean_time_ms);
    run_times.push_back(row.max_time_ms);
    works.push_back(row.mean_work);
    residuals.push_back(residual * residual);
  }
  StaticScore score;
  score.range_m = inputs.ranges.looks[range].range_m;
  score.mean_error_m = mean_of(errors);
  score.mean_time_ms = mean_of(times);
  score.max_site_time_ms = std::ranges::max(times);
  score.max_run_time_ms = std::ranges::max(run_times);
  score.mean_work = mean_of(works);
  for (const double error : errors) {
    deviations.push_back((error - score.mean_error_m) * (error - score.mean_error_m));
  }
  const double total = ordered_sum(deviations);
  score.r_squared = total > 0.0 ? 1.0 - ordered_sum(residuals) / total : 0.0;
  score.rmse_m = std::sqrt(mean_of(residuals));
  return score;
}

void append_reliability(const EvaluationInputs& inputs, std::size_t limit,
                        std::vector<ReliabilityBin>& reliability) {
  constexpr std::size_t kBinCount = 10;
  std::vector<ReliabilityBin> bins(kBinCount);
  for (const std::size_t site : inputs.judged_sites) {
    for (std::size_t range = 0; range <= inputs.longest(); ++range) {
      const double promised = inputs.predicted.probability(site, range, limit);
      const auto tenth = static_cast<std::size_t>(promised * static_cast<double>(kBinCount));
      ReliabilityBin& bin = bins[std::min(tenth, kBinCount - 1)];
      bin.promised += promised;
      bin.observed += inputs.judged.row(site, range).mean_m <= inputs.limit_m(limit) ? 1.0 : 0.0;
      ++bin.count;
    }
  }
  for (ReliabilityBin& bin : bins) {
    if (bin.count == 0) continue;
    bin.limit_m = inputs.limit_m(limit);
    bin.promised /= static_cast<double>(bin.count);
    bin.observed /= static_cast<double>(bin.count);
    reliability.push_back(bin);
  }
}

}  // namespace sightline
