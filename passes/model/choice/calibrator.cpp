#include "passes/model/choice/calibrator.h"

#include <algorithm>

#include "passes/model/promise/promise_text.h"

namespace sightline {
namespace {

double& threshold_of(CaseKind kind, LimitPromise& promise) {
  return kind == CaseKind::kHistory ? promise.history_threshold : promise.probability_threshold;
}

// The shares of both groups' cases together.
LimitPromise of_both_groups(CaseKind kind, const std::vector<Calibration>& groups,
                            const LimitPromise& pooled) {
  LimitPromise both = pooled;
  double cases = 0.0, answered = 0.0, missed = 0.0;
  for (const Calibration& group : groups) {
    LimitPromise promise = group.promise;
    const auto count = static_cast<double>(group.case_count);
    cases += count;
    answered += count * promise.answered_share;
    missed += count * promise.answered_share * promise.calibration_miss_share;
    both.is_earned = both.is_earned && promise.is_earned;
    threshold_of(kind, both) = std::min(threshold_of(kind, both), threshold_of(kind, promise));
  }
  both.answered_share = answered / cases;
  both.calibration_miss_share = answered > 0.0 ? missed / answered : 0.0;
  both.statement = groups_statement(groups.front().promise, groups.back().promise);
  return both;
}

}  // namespace

LimitPromise Calibrator::next(CaseKind kind, std::size_t limit,
                              const std::vector<std::uint8_t>* look_of_site) {
  CalibrationOptions options = options_;
  options.look_of_site = options_.look_of_site = look_of_site;
  const LimitPromise pooled = calibrate(kind, limit, options).promise;
  return look_of_site == nullptr ? pooled : next_of_groups(kind, limit, pooled);
}

Calibration Calibrator::calibrate(CaseKind kind, std::size_t limit,
                                  const CalibrationOptions& options) {
  const std::size_t group =
      options.group ? static_cast<std::size_t>(*options.group) : kThresholdGroupCount;
  std::optional<Choice>& tighter = tighter_[static_cast<std::size_t>(kind)][group];
  Calibration calibration =
      calibrate_probability(model_, limit, kind, options, tighter ? &*tighter : nullptr);
  tighter = calibration.choice;
  return calibration;
}

LimitPromise Calibrator::next_of_groups(CaseKind kind, std::size_t limit,
                                        const LimitPromise& pooled) {
  LimitPromise of_all = pooled;
  GroupThresholds& thresholds = thresholds_[static_cast<std::size_t>(kind)];
  thresholds.fill(threshold_of(kind, of_all));
  std::vector<Calibration> groups;
  for (const ThresholdGroup group : {ThresholdGroup::kConstrained, ThresholdGroup::kWeak}) {
    const std::uint32_t blocks = calibration_drives_of(model_, kind, group).count.blocks;
    const bool is_fixed = options_.risk_control == RiskControl::kFixed;
    if (blocks < kLeastGroupBlocks || is_fixed) return pooled;
    CalibrationOptions options = options_;
    options.group = group;
    groups.push_back(calibrate(kind, limit, options));
  }
  for (std::size_t group = 0; group < groups.size(); ++group) {
    thresholds[group] = threshold_of(kind, groups[group].promise);
  }
  of_all.probability_threshold = kind == CaseKind::kMapOnly ? 1.0 : pooled.probability_threshold;
  of_all.history_threshold = kind == CaseKind::kHistory ? 1.0 : pooled.history_threshold;
  of_all.is_earned = true;
  return of_both_groups(kind, groups, of_all);
}

}  // namespace sightline
