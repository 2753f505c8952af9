#include "passes/model/calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "formats/text/table.h"
#include "passes/model/risk_control.h"

namespace sightline {
namespace {

// Steps of P(error <= limit): 200 trees with five labels a leaf resolve no finer differences that
// would last from one seed to the next.
constexpr int kThresholdSteps = 200;

// Blocks below these see the same walls (schemas/definitions.md, "Error model and choice of
// range"), and what they witness is no promise.
constexpr double kIndependentBlock_m = 60.0;
constexpr double kIndependentBuffer_m = 25.0;

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100.0 * share);
  return text;
}

std::string kilometres(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f km", std::ceil(length_m / 100.0) / 10.0);
  return text;
}

Choice choose_out_of_fold(const ErrorModel& model, std::size_t limit, double threshold,
                          double dilation_m, const Choice* tighter) {
  Choice choice = choose_by_probability(model.out_of_fold, limit, {threshold, threshold});
  dilate(route_of(model.sites), dilation_m, choice);
  if (tighter != nullptr) cap_by_tighter(*tighter, choice);
  return choice;
}

// The labelled cases of one kind, by blocks that hold any.
struct Witnesses {
  const ErrorModel& model;
  std::vector<std::size_t> cases;
  std::vector<std::uint32_t> block_of_case;
  std::vector<std::uint32_t> cases_in_block;  // none 0
};

Witnesses witnesses_of(const ErrorModel& model, CaseKind kind) {
  constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();
  Witnesses witnesses{model, {}, {}, {}};
  std::vector<std::uint32_t> dense(model.card.block_count, kEmpty);
  for (std::size_t i = 0; i < model.sites.size(); ++i) {
    const TrainedSite& site = model.sites[i];
    if (site.has_label == 0 || (site.has_history == 1) != (kind == CaseKind::kHistory)) continue;
    std::uint32_t& block = dense[site.block];
    if (block == kEmpty) {
      block = static_cast<std::uint32_t>(witnesses.cases_in_block.size());
      witnesses.cases_in_block.push_back(0);
    }
    witnesses.cases.push_back(i);
    witnesses.block_of_case.push_back(block);
    ++witnesses.cases_in_block[block];
  }
  return witnesses;
}

std::vector<std::uint32_t> missed_cases(const Witnesses& witnesses, double limit_m,
                                        const Choice& choice) {
  std::vector<std::uint32_t> missed(witnesses.cases_in_block.size(), 0);
  for (std::size_t i = 0; i < witnesses.cases.size(); ++i) {
    const std::size_t site = witnesses.cases[i];
    const double error_m = witnesses.model.measured(site, choice.range_index[site]);
    if (error_m > limit_m) ++missed[witnesses.block_of_case[i]];
  }
  return missed;
}

Misses misses_of_rule(const Witnesses& witnesses, std::size_t limit,
                      const CalibrationOptions& options, const Choice* tighter) {
  const ErrorModel& model = witnesses.model;
  const double limit_m = model.out_of_fold.limits_m[limit];
  Misses misses;
  misses.sites_in_block = witnesses.cases_in_block;
  const auto try_threshold = [&](double threshold) {
    misses.thresholds.push_back(threshold);
    misses.in_block.push_back(
        missed_cases(witnesses, limit_m,
                     choose_out_of_fold(model, limit, threshold, options.dilation_m, tighter)));
  };
  if (options.risk_control == RiskControl::kFixed) {
    try_threshold(options.fixed_threshold);
    return misses;
  }
  for (int i = 1; i <= kThresholdSteps; ++i) {
    try_threshold(static_cast<double>(i) / kThresholdSteps);
  }
  return misses;
}

RiskDecision decide(const Misses& misses, const CalibrationOptions& options) {
  const RiskOptions risk{options.alpha, options.delta};
  if (options.risk_control == RiskControl::kConformal) return decide_conformally(misses, risk);
  if (options.risk_control == RiskControl::kLearnThenTest) return decide_by_testing(misses, risk);
  return decide_empirically(misses, options.alpha);
}

bool are_blocks_independent(const TrainingCard& card) {
  return card.block_m >= kIndependentBlock_m && card.buffer_m >= kIndependentBuffer_m;
}

// A match to the very map is no truth: against it errors vanish with range by construction.
bool are_poses_known(const TrainingCard& card) {
  return card.reference == ErrorReference::kKnownPose;
}

std::string observed(const LimitPromise& promise) {
  return percent(promise.calibration_miss_share) + " missed out of fold in " +
         std::to_string(promise.block_count) + " blocks";
}

std::string earned_statement(const LimitPromise& promise) {
  const std::string limit = format_double(promise.limit_m) + " m";
  const std::string share = percent(promise.alpha);
  if (promise.method == risk_control_name(RiskControl::kConformal)) {
    return "at most " + share + " of places like these are expected to miss " + limit +
           " (conformal risk control; " + observed(promise) + ")";
  }
  return "with " + percent(1.0 - promise.delta) + " confidence at most " + share +
         " of places like these miss " + limit + " (learn then test; " + observed(promise) + ")";
}

// Of the witnesses at any range.
double least_error_m(const Witnesses& witnesses) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const std::size_t site : witnesses.cases) {
    for (std::size_t range = 0; range < witnesses.model.ranges.size(); ++range) {
      least_m = std::min(least_m, witnesses.model.measured(site, range));
    }
  }
  return least_m;
}

std::string unearned_statement(const LimitPromise& promise, const Witnesses& witnesses,
                               std::uint32_t needed_blocks) {
  const TrainingCard& card = witnesses.model.card;
  if (promise.method == risk_control_name(RiskControl::kFixed)) {
    return "nothing is promised: the threshold was given; " + observed(promise);
  }
  if (promise.method == risk_control_name(RiskControl::kEmpirical)) {
    return "nothing is promised: the threshold fits what was seen; " + observed(promise);
  }
  const double least_m = least_error_m(witnesses);
  if (promise.block_count > 0 && least_m > promise.limit_m) {
    return "nothing is promised: no range reached " + format_double(promise.limit_m) +
           " m anywhere, the least error measured is " + format_double(least_m) + " m";
  }
  const std::string fallback = "; the threshold fits what was seen instead: " + observed(promise);
  if (!are_poses_known(card)) {
    return "nothing is promised: errors were measured against matches to the map itself, known "
           "poses "
           "(measure-error.reference=known) can earn a promise" +
           fallback;
  }
  if (!are_blocks_independent(card)) {
    return "nothing is promised: blocks of " + format_double(card.block_m) +
           " m with a buffer of " + format_double(card.buffer_m) +
           " m see the same walls, 60 m and 25 m are needed" + fallback;
  }
  if (promise.block_count < needed_blocks) {
    const double missing_m = (needed_blocks - promise.block_count) * card.block_m;
    return "nothing is promised: " + std::to_string(promise.block_count) + " blocks of " +
           format_double(card.block_m) + " m cannot earn " + percent(promise.alpha) + ", " +
           std::to_string(needed_blocks) + " can, " + kilometres(missing_m) +
           " more of measured route" + fallback;
  }
  return "nothing is promised: even the strictest threshold misses " +
         format_double(promise.limit_m) + " m too often for " + percent(promise.alpha) + fallback;
}

}  // namespace

Calibration calibrate_probability(const ErrorModel& model, std::size_t limit, CaseKind kind,
                                  const CalibrationOptions& options, const Choice* tighter) {
  const Witnesses witnesses = witnesses_of(model, kind);
  const Misses misses = misses_of_rule(witnesses, limit, options, tighter);
  RiskDecision decision = decide(misses, options);
  if (decision.is_earned && !(are_blocks_independent(model.card) && are_poses_known(model.card))) {
    decision = decide_empirically(misses, options.alpha);
  }
  Calibration calibration;
  LimitPromise& promise = calibration.promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  (kind == CaseKind::kHistory ? promise.history_threshold : promise.probability_threshold) =
      decision.threshold;
  promise.alpha = options.risk_control == RiskControl::kFixed ? 0.0 : options.alpha;
  promise.delta = options.risk_control == RiskControl::kLearnThenTest ? options.delta : 0.0;
  promise.block_count = static_cast<std::uint32_t>(misses.sites_in_block.size());
  promise.is_earned = decision.is_earned;
  promise.calibration_miss_share = decision.miss_share;
  promise.method = risk_control_name(options.risk_control);
  promise.statement = decision.is_earned
                          ? earned_statement(promise)
                          : unearned_statement(promise, witnesses, decision.needed_blocks);
  calibration.choice =
      choose_out_of_fold(model, limit, decision.threshold, options.dilation_m, tighter);
  return calibration;
}

LimitPromise assess_mean_rule(const ErrorModel& model, std::size_t limit) {
  LimitPromise promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  promise.block_count = model.card.block_count;
  promise.method = "mean";
  const Witnesses witnesses = witnesses_of(model, CaseKind::kMapOnly);
  Misses misses;
  misses.sites_in_block = witnesses.cases_in_block;
  misses.thresholds = {0.0};
  misses.in_block = {
      missed_cases(witnesses, promise.limit_m, choose_by_mean(model.out_of_fold, promise.limit_m))};
  promise.calibration_miss_share = miss_share(misses, 0);
  promise.statement =
      "nothing is promised: a mean within the limit says little about misses; " + observed(promise);
  return promise;
}

}  // namespace sightline
