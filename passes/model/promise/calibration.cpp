#include "passes/model/promise/calibration.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"
#include "passes/model/promise/promise_text.h"

namespace sightline {
namespace {

// Steps of P(error <= limit): 200 trees with five labels a leaf resolve no finer differences that
// would last from one seed to the next.
constexpr int kThresholdSteps = 200;

Choice choose_out_of_fold(const ErrorModel& model, std::size_t limit, double threshold,
                          double dilation_m, const Choice* tighter) {
  Choice choice = choose_by_probability(model.out_of_fold, limit, {threshold, threshold});
  dilate(route_of(model.sites), dilation_m, choice);
  if (tighter != nullptr) cap_by_tighter(*tighter, choice);
  return choice;
}

Misses misses_of_rule(const CalibrationDrives& calibration_drives, std::size_t limit,
                      const CalibrationOptions& options, const Choice* tighter) {
  const ErrorModel& model = calibration_drives.model;
  const double limit_m = model.out_of_fold.limits_m[limit];
  Misses misses;
  misses.sites_in_block = calibration_drives.cases_in_block;
  const auto try_threshold = [&](double threshold) {
    misses.thresholds.push_back(threshold);
    misses.in_block.push_back(
        missed_cases(calibration_drives, limit_m,
                     choose_out_of_fold(model, limit, threshold, options.dilation_m, tighter)));
  };
  const bool is_given = options.risk_control == RiskControl::kFixed;
  if (is_given) try_threshold(options.fixed_threshold);
  for (int i = 1; i <= kThresholdSteps && !is_given; ++i) {
    try_threshold(static_cast<double>(i) / kThresholdSteps);
  }
  return misses;
}

RiskDecision decide(const Misses& misses, const CalibrationOptions& options, double alpha) {
  const RiskOptions risk{alpha, options.delta};
  if (options.risk_control == RiskControl::kConformal) return decide_conformally(misses, risk);
  if (options.risk_control == RiskControl::kLearnThenTest) return decide_by_testing(misses, risk);
  return decide_empirically(misses, alpha);
}

// A share of misses, and what the calibration makes of it. 0: none was asked about.
struct AlphaDecision {
  double alpha = 0.0;
  RiskDecision decision;
};

AlphaDecision decide_for(const Misses& misses, const CalibrationOptions& options, double alpha,
                         const TrainingCard& card) {
  RiskDecision decision = decide(misses, options, alpha);
  if (decision.is_earned && !(are_blocks_independent(card) && are_poses_known(card))) {
    decision = decide_empirically(misses, alpha);
  }
  return {alpha, decision};
}

// The share that was named; else the strictest of kStrictness that is earned about the next drive,
// kUnearned where none is. `stricter`: the one before it, which is not.
AlphaDecision strictest_earned(const Misses& misses, const CalibrationOptions& options,
                               const CalibrationDrives& calibration_drives,
                               AlphaDecision& stricter) {
  constexpr double kStrictness[] = {0.01, 0.02, 0.05, 0.10};
  constexpr double kUnearned = 0.05;
  const TrainingCard& card = calibration_drives.model.card;
  if (options.alpha > 0.0) return decide_for(misses, options, options.alpha, card);
  const bool is_next_drive = calibration_drives.count.scope == PromiseScope::kNextDrive;
  for (const double alpha : kStrictness) {
    const AlphaDecision decided = decide_for(misses, options, alpha, card);
    if (decided.decision.is_earned && is_next_drive) return decided;
    stricter = decided;
  }
  stricter = {};
  return decide_for(misses, options, kUnearned, card);
}

void take_counts(const CalibrationCount& count, LimitPromise& promise) {
  promise.block_count = count.blocks;
  promise.place_count = count.places;
  promise.drive_count = count.drives;
  promise.scope = count.scope;
}

// What the decision is worth, in numbers and words.
void state(const RiskDecision& decision, const CalibrationDrives& calibration_drives,
           const Choice& choice, LimitPromise& promise) {
  const bool is_next_drive = calibration_drives.count.scope == PromiseScope::kNextDrive;
  promise.is_earned = decision.is_earned && is_next_drive;
  if (promise.is_earned) {
    promise.statement = earned_statement(
        promise, worst_place_miss_share(calibration_drives, promise.limit_m, choice));
  } else if (decision.is_earned) {
    promise.statement = this_drive_statement(promise, calibration_drives.model.card);
  } else {
    promise.statement = unearned_statement(promise, calibration_drives, decision.needed_blocks);
  }
}

// Sums of shares are exact to about 1e-15 a block; a bound that is met exactly must count as met.
constexpr double kRounding = 1e-12;

double block_loss(const Misses& misses, std::size_t threshold, std::size_t block) {
  return static_cast<double>(misses.in_block[threshold][block]) /
         static_cast<double>(misses.sites_in_block[block]);
}

// [threshold]: mean over blocks of the worst loss at this or any stricter threshold.
std::vector<double> monotone_block_risk(const Misses& misses) {
  const std::size_t block_count = misses.sites_in_block.size();
  std::vector<double> worst(block_count, 0.0);
  std::vector<double> risk(misses.thresholds.size(), 0.0);
  for (std::size_t t = misses.thresholds.size(); t-- > 0;) {
    for (std::size_t block = 0; block < block_count; ++block) {
      worst[block] = std::max(worst[block], block_loss(misses, t, block));
    }
    risk[t] = std::accumulate(worst.begin(), worst.end(), 0.0) / static_cast<double>(block_count);
  }
  return risk;
}

// Kullback-Leibler divergence of two coins.
double divergence(double p, double q) {
  double sum = 0.0;
  if (p > 0.0) sum += p * portable_log(p / q);
  if (p < 1.0) sum += (1.0 - p) * portable_log((1.0 - p) / (1.0 - q));
  return sum;
}

double p_value(double mean_loss, double alpha, std::size_t block_count) {
  if (mean_loss >= alpha) return 1.0;
  return portable_exp(-static_cast<double>(block_count) * divergence(mean_loss, alpha));
}

RiskDecision earned_at(const Misses& misses, std::size_t threshold, std::uint32_t needed_blocks) {
  return {misses.thresholds[threshold], true, miss_share(misses, threshold), needed_blocks};
}

RiskDecision unearned(const Misses& misses, double alpha, std::uint32_t needed_blocks) {
  RiskDecision decision = decide_empirically(misses, alpha);
  decision.needed_blocks = needed_blocks;
  return decision;
}

}  // namespace

Calibration calibrate_probability(const ErrorModel& model, std::size_t limit, CaseKind kind,
                                  const CalibrationOptions& options, const Choice* tighter) {
  const CalibrationDrives calibration_drives = calibration_drives_of(model, kind);
  const Misses misses = misses_of_rule(calibration_drives, limit, options, tighter);
  AlphaDecision stricter;
  const auto [alpha, decision] = strictest_earned(misses, options, calibration_drives, stricter);
  Calibration calibration;
  LimitPromise& promise = calibration.promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  (kind == CaseKind::kHistory ? promise.history_threshold : promise.probability_threshold) =
      decision.threshold;
  promise.alpha = options.risk_control == RiskControl::kFixed ? 0.0 : alpha;
  promise.delta = options.risk_control == RiskControl::kLearnThenTest ? options.delta : 0.0;
  take_counts(calibration_drives.count, promise);
  promise.calibration_miss_share = decision.miss_share;
  promise.method = risk_control_name(options.risk_control);
  calibration.choice =
      choose_out_of_fold(model, limit, decision.threshold, options.dilation_m, tighter);
  state(decision, calibration_drives, calibration.choice, promise);
  if (promise.is_earned && stricter.alpha > 0.0) {
    promise.statement += stricter_statement(promise, calibration_drives, stricter.alpha,
                                            stricter.decision.needed_blocks);
  }
  return calibration;
}

LimitPromise assess_mean_rule(const ErrorModel& model, std::size_t limit) {
  LimitPromise promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  promise.method = "mean";
  const CalibrationDrives calibration_drives = calibration_drives_of(model, CaseKind::kMapOnly);
  take_counts(calibration_drives.count, promise);
  Misses misses;
  misses.sites_in_block = calibration_drives.cases_in_block;
  misses.thresholds = {0.0};
  misses.in_block = {missed_cases(calibration_drives, promise.limit_m,
                                  choose_by_mean(model.out_of_fold, promise.limit_m))};
  promise.calibration_miss_share = miss_share(misses, 0);
  promise.statement = mean_rule_statement(promise);
  return promise;
}

double miss_share(const Misses& misses, std::size_t threshold) {
  const auto& missed = misses.in_block[threshold];
  const double missed_count =
      static_cast<double>(std::accumulate(missed.begin(), missed.end(), std::uint64_t{0}));
  const double site_count = static_cast<double>(std::accumulate(
      misses.sites_in_block.begin(), misses.sites_in_block.end(), std::uint64_t{0}));
  return missed_count / site_count;
}

RiskDecision decide_empirically(const Misses& misses, double alpha) {
  SIGHTLINE_CHECK(!misses.thresholds.empty() && !misses.sites_in_block.empty());
  std::size_t chosen = misses.thresholds.size() - 1;
  const double allowed = std::max(alpha, miss_share(misses, chosen)) + kRounding;
  while (chosen > 0 && miss_share(misses, chosen - 1) <= allowed) --chosen;
  return {misses.thresholds[chosen], false, miss_share(misses, chosen), 0};
}

RiskDecision decide_conformally(const Misses& misses, const RiskOptions& options) {
  const auto n = static_cast<double>(misses.sites_in_block.size());
  const auto needed = static_cast<std::uint32_t>(std::ceil(1.0 / options.alpha - 1.0 - kRounding));
  const std::vector<double> risk = monotone_block_risk(misses);
  const auto is_within = [&](std::size_t t) {
    return n / (n + 1.0) * risk[t] + 1.0 / (n + 1.0) <= options.alpha + kRounding;
  };
  std::size_t chosen = misses.thresholds.size() - 1;
  if (!is_within(chosen)) return unearned(misses, options.alpha, needed);
  while (chosen > 0 && is_within(chosen - 1)) --chosen;
  return earned_at(misses, chosen, needed);
}

RiskDecision decide_by_testing(const Misses& misses, const RiskOptions& options) {
  const std::size_t block_count = misses.sites_in_block.size();
  const auto needed = static_cast<std::uint32_t>(
      std::ceil(portable_log(options.delta) / portable_log(1.0 - options.alpha) - kRounding));
  const auto passes = [&](std::size_t t) {
    double loss = 0.0;
    for (std::size_t block = 0; block < block_count; ++block) loss += block_loss(misses, t, block);
    loss /= static_cast<double>(block_count);
    return p_value(loss, options.alpha, block_count) <= options.delta + kRounding;
  };
  std::size_t chosen = misses.thresholds.size() - 1;
  if (!passes(chosen)) return unearned(misses, options.alpha, needed);
  while (chosen > 0 && passes(chosen - 1)) --chosen;
  return earned_at(misses, chosen, needed);
}

}  // namespace sightline
