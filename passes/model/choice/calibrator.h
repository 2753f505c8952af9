#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/annotation/range_table.h"
#include "formats/model/error_model.h"
#include "passes/model/promise/calibration.h"
#include "passes/pass/options.h"

// The thresholds of choose-ranges.

namespace sightline {

// Of choose-ranges.
struct ChooseRangesOptions {
  Selection selection = Selection::kProbability;  // kMean: the paper's rule
  RiskControl risk_control = RiskControl::kConformal;
  double alpha = 0.05;                 // share of misses that is allowed
  double delta = 0.1;                  // learn-then-test: how often the promise may fail
  double probability_threshold = 0.8;  // p* of "fixed"
  double dilation_m = 3.0;
  bool extrapolated_takes_static = true;
};
std::vector<OptionField> option_fields(ChooseRangesOptions& options);

// Calibrates limit after limit, each capped by the choice for the tighter one before it.
class Calibrator {
 public:
  Calibrator(const ErrorModel& model, const ChooseRangesOptions& options)
      : model_(model),
        options_{options.risk_control, options.alpha, options.delta, options.probability_threshold,
                 options.dilation_m} {}

  // `look_of_site`: as in CalibrationOptions. In the promise of several groups (group_thresholds)
  // the threshold is the least of theirs.
  LimitPromise next(CaseKind kind, std::size_t limit,
                    const std::vector<std::uint8_t>* look_of_site = nullptr);

  // p* of looks by groups of places, set by the last next() of that kind with looks: the group's
  // own where both groups have kLeastGroupBlocks, else that of all.
  using GroupThresholds = std::array<double, kThresholdGroupCount>;
  [[nodiscard]] const GroupThresholds& group_thresholds(CaseKind kind) const {
    return thresholds_[static_cast<std::size_t>(kind)];
  }

  // 2 / alpha - 1 at 5 %. The same at any alpha, so that a stricter one answers no more.
  static constexpr std::uint32_t kLeastGroupBlocks = 39;

 private:
  Calibration calibrate(CaseKind kind, std::size_t limit, const CalibrationOptions& options);
  LimitPromise next_of_groups(CaseKind kind, std::size_t limit, const LimitPromise& pooled);

  const ErrorModel& model_;
  CalibrationOptions options_;
  // Of the model's sites: [kind][group, then all].
  std::optional<Choice> tighter_[2][kThresholdGroupCount + 1];
  std::array<GroupThresholds, 2> thresholds_{};
};

}  // namespace sightline
