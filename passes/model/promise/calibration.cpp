#include "passes/model/promise/calibration.h"

#include <utility>

#include "passes/model/promise/promise_text.h"

namespace sightline {
namespace {

Choice choose_out_of_fold(const ErrorModel& model, std::size_t limit, double threshold,
                          const CalibrationOptions& options, const Choice* tighter) {
  Choice choice;
  if (options.look_of_site != nullptr) {
    const std::vector<double> everywhere(model.sites.size(), threshold);
    choice = choose_given(model.out_of_fold, limit, everywhere, *options.look_of_site);
  } else {
    choice = choose_by_probability(model.out_of_fold, limit, {threshold, threshold});
    dilate(route_of(model.sites), options.dilation_m, choice);
  }
  if (tighter != nullptr) cap_by_tighter(*tighter, choice);
  return choice;
}

BlockCounts counts_of_rule(const CalibrationDrives& calibration_drives, std::size_t limit,
                           const CalibrationOptions& options, const Choice* tighter) {
  const ErrorModel& model = calibration_drives.model;
  const double limit_m = model.out_of_fold.limits_m[limit];
  BlockCounts counts;
  counts.sites_in_block = calibration_drives.cases_in_block;
  counts.thresholds = tried_thresholds();
  if (options.risk_control == RiskControl::kFixed) counts.thresholds = {options.fixed_threshold};
  for (const double threshold : counts.thresholds) {
    const Choice choice = choose_out_of_fold(model, limit, threshold, options, tighter);
    CaseCounts cases = count_cases(calibration_drives, limit_m, choice);
    counts.answered.push_back(std::move(cases.answered));
    counts.missed.push_back(std::move(cases.missed));
  }
  return counts;
}

// A bound is valid only for blocks that do not see the same walls and errors of known poses.
RiskDecision decide(const BlockCounts& counts, const CalibrationOptions& options,
                    const TrainingCard& card) {
  const RiskOptions risk{options.alpha, options.delta};
  if (!are_blocks_independent(card) || !are_poses_known(card)) {
    return decide_empirically(counts, options.alpha);
  }
  if (options.risk_control == RiskControl::kConformal) {
    return decide_nested(&decide_conformally, counts, risk);
  }
  if (options.risk_control == RiskControl::kLearnThenTest) {
    return decide_nested(&decide_by_testing, counts, risk);
  }
  return decide_empirically(counts, options.alpha);
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
    promise.statement = unearned_statement(promise, calibration_drives, decision);
  }
}

}  // namespace

Calibration calibrate_probability(const ErrorModel& model, std::size_t limit, CaseKind kind,
                                  const CalibrationOptions& options, const Choice* tighter) {
  const CalibrationDrives calibration_drives = calibration_drives_of(model, kind, options.group);
  const BlockCounts counts = counts_of_rule(calibration_drives, limit, options, tighter);
  const RiskDecision decision = decide(counts, options, calibration_drives.model.card);
  Calibration calibration;
  calibration.case_count = calibration_drives.cases.size();
  LimitPromise& promise = calibration.promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  (kind == CaseKind::kHistory ? promise.history_threshold : promise.probability_threshold) =
      decision.threshold;
  promise.alpha = options.risk_control == RiskControl::kFixed ? 0.0 : options.alpha;
  promise.delta = options.risk_control == RiskControl::kLearnThenTest ? options.delta : 0.0;
  take_counts(calibration_drives.count, promise);
  promise.calibration_miss_share = decision.miss_share;
  promise.answered_share = decision.answered_share;
  promise.method = risk_control_name(options.risk_control);
  calibration.choice = choose_out_of_fold(model, limit, decision.threshold, options, tighter);
  state(decision, calibration_drives, calibration.choice, promise);
  return calibration;
}

LimitPromise assess_mean_rule(const ErrorModel& model, std::size_t limit) {
  LimitPromise promise;
  promise.limit_m = model.out_of_fold.limits_m[limit];
  promise.method = "mean";
  const CalibrationDrives calibration_drives = calibration_drives_of(model, CaseKind::kMapOnly);
  take_counts(calibration_drives.count, promise);
  CaseCounts cases = count_cases(calibration_drives, promise.limit_m,
                                 choose_by_mean(model.out_of_fold, promise.limit_m));
  const BlockCounts counts{{0.0},
                           calibration_drives.cases_in_block,
                           {std::move(cases.answered)},
                           {std::move(cases.missed)}};
  const RiskDecision decision = decide_empirically(counts, 0.0);
  promise.calibration_miss_share = decision.miss_share;
  promise.answered_share = decision.answered_share;
  promise.statement = mean_rule_statement(promise);
  return promise;
}

}  // namespace sightline
