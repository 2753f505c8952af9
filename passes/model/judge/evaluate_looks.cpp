#include "passes/model/judge/evaluate_looks.h"

#include <algorithm>
#include <functional>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/evaluation/look_evaluation.h"

namespace sightline {
namespace {

struct Judge {
  const RangeTable& choice;        // of looks that take a sample
  const MeasuredError& samples;    // beginning with the looks of the choice
  const MeasuredError& ranges;     // the last is the reference
  std::vector<std::size_t> sites;  // that were measured
};

// Sums over the judged sites, one row each.
struct Sums {
  std::vector<double> error_m, time_ms, work;
};

using RowOf = std::function<const ErrorRow&(std::size_t site)>;

Sums sums_of(const Judge& judge, const RowOf& row_of) {
  Sums sums;
  for (const std::size_t site : judge.sites) {
    const ErrorRow& row = row_of(site);
    sums.error_m.push_back(row.mean_m);
    sums.time_ms.push_back(row.mean_time_ms);
    sums.work.push_back(row.mean_work);
  }
  return sums;
}

double coverage_of(const Sums& sums, double limit_m) {
  const auto met =
      std::ranges::count_if(sums.error_m, [&](double error_m) { return error_m <= limit_m; });
  return static_cast<double>(met) / static_cast<double>(sums.error_m.size());
}

double ratio(const std::vector<double>& part, const std::vector<double>& whole) {
  const double sum = ordered_sum(whole);
  return sum > 0.0 ? ordered_sum(part) / sum : 0.0;
}

Sums reference_of(const Judge& judge) {
  const std::size_t longest = judge.ranges.looks.size() - 1;
  return sums_of(
      judge, [&](std::size_t site) -> const ErrorRow& { return judge.ranges.row(site, longest); });
}

StaticLook static_look(const Judge& judge, const MeasuredError& measured, std::size_t look,
                       const Sums& reference) {
  const Sums sums =
      sums_of(judge, [&](std::size_t site) -> const ErrorRow& { return measured.row(site, look); });
  StaticLook scored;
  scored.look = measured.looks[look];
  for (const LimitPromise& promise : judge.choice.promises) {
    scored.coverage.push_back(coverage_of(sums, promise.limit_m));
  }
  scored.mean_error_m = ordered_sum(sums.error_m) / static_cast<double>(sums.error_m.size());
  scored.time_ratio = ratio(sums.time_ms, reference.time_ms);
  scored.work_ratio = ratio(sums.work, reference.work);
  return scored;
}

LookRuleScore score_of(const Sums& sums, const Sums& reference, double limit_m, LookRule rule) {
  LookRuleScore score{rule, limit_m, coverage_of(sums, limit_m),
                      ratio(sums.time_ms, reference.time_ms), ratio(sums.work, reference.work)};
  score.answered_miss_share = 1.0 - score.coverage;
  return score;
}

// Of the map's answers and of the places that it does not answer.
void count_answers(const Judge& judge, std::size_t limit, LookRuleScore& score) {
  const std::size_t dearest = judge.choice.looks.size() - 1;
  std::vector<double> missed, truly_unmet;
  for (const std::size_t site : judge.sites) {
    const bool is_answered = (judge.choice.flags_of(site, limit) & kUnmet) == 0;
    const std::size_t look = is_answered ? judge.choice.range(site, limit) : dearest;
    const bool misses = judge.samples.row(site, look).mean_m > score.limit_m;
    (is_answered ? missed : truly_unmet).push_back(misses ? 1.0 : 0.0);
  }
  score.unmet_share =
      static_cast<double>(truly_unmet.size()) / static_cast<double>(judge.sites.size());
  score.answered_miss_share = missed.empty() ? 0.0 : mean_of(missed);
  score.truly_unmet_share = truly_unmet.empty() ? 0.0 : mean_of(truly_unmet);
}

// The cheapest look of the choice, by its work here, that truly met the limit; else the most
// accurate one.
const ErrorRow& oracle_row(const Judge& judge, std::size_t site, double limit_m) {
  const auto is_better = [&](const ErrorRow& row, const ErrorRow& than) {
    const bool meets = row.mean_m <= limit_m;
    if (meets != (than.mean_m <= limit_m)) return meets;
    return meets ? row.mean_work < than.mean_work : row.mean_m < than.mean_m;
  };
  std::size_t best = 0;
  for (std::size_t look = 1; look < judge.choice.looks.size(); ++look) {
    if (is_better(judge.samples.row(site, look), judge.samples.row(site, best))) best = look;
  }
  return judge.samples.row(site, best);
}

LookRuleScore static_score(const LookEvaluation& evaluation, std::size_t limit, LookRule rule,
                           double coverage) {
  std::vector<CoveredCost> times, works;
  for (const StaticLook& look : evaluation.statics) {
    if (rule == LookRule::kSameWithoutMap && look.look.is_by_normals) continue;
    times.push_back({look.coverage[limit], look.time_ratio});
    works.push_back({look.coverage[limit], look.work_ratio});
  }
  const CostAtCoverage time = cost_at_coverage(times, coverage);
  return {rule,
          evaluation.limits_m[limit],
          time.coverage,
          time.cost,
          cost_at_coverage(works, coverage).cost,
          0.0,
          1.0 - time.coverage};
}

void append_rules(const Judge& judge, std::size_t limit, const Sums& reference,
                  LookEvaluation& evaluation) {
  const double limit_m = evaluation.limits_m[limit];
  const Sums of_map = sums_of(judge, [&](std::size_t site) -> const ErrorRow& {
    return judge.samples.row(site, judge.choice.range(site, limit));
  });
  LookRuleScore map = score_of(of_map, reference, limit_m, LookRule::kMap);
  count_answers(judge, limit, map);
  evaluation.rules.push_back(map);
  for (const LookRule rule : {LookRule::kSameEverywhere, LookRule::kSameWithoutMap}) {
    evaluation.rules.push_back(static_score(evaluation, limit, rule, map.coverage));
  }
  const Sums oracle = sums_of(
      judge, [&](std::size_t site) -> const ErrorRow& { return oracle_row(judge, site, limit_m); });
  evaluation.rules.push_back(score_of(oracle, reference, limit_m, LookRule::kOracle));
}

}  // namespace

Result<LookEvaluation> evaluate_looks(const RangeTable& choice,
                                      const ByFamily<MeasuredError>& judged) {
  const MeasuredError& ranges = judged.ranges;
  Judge judge{choice, *judged.samples, ranges, {}};
  const std::vector<Look>& looks = judge.samples.looks;
  if (looks.size() < choice.looks.size() ||
      !std::equal(choice.looks.begin(), choice.looks.end(), looks.begin())) {
    return Error{ErrorCode::kMismatchedInputs, "the drive was measured at other looks"};
  }
  for (std::size_t site = 0; site < ranges.scan_of_site.size(); ++site) {
    if (ranges.scan_of_site[site] >= 0) judge.sites.push_back(site);
  }
  const Sums reference = reference_of(judge);
  LookEvaluation evaluation;
  evaluation.has_baselines = looks.size() > choice.looks.size();
  for (const LimitPromise& promise : choice.promises)
    evaluation.limits_m.push_back(promise.limit_m);
  for (std::size_t look = 0; look < looks.size(); ++look) {
    evaluation.statics.push_back(static_look(judge, judge.samples, look, reference));
  }
  for (std::size_t range = 0; range < ranges.looks.size(); ++range) {
    evaluation.statics.push_back(static_look(judge, ranges, range, reference));
  }
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    append_rules(judge, limit, reference, evaluation);
  }
  return evaluation;
}

}  // namespace sightline
