#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/annotation/range_table.h"
#include "formats/model/error_model.h"
#include "passes/model/promise/calibration_drives.h"
#include "passes/model/promise/risk_control.h"
#include "passes/model/promise/selection.h"

// Sets p*, the probability that a chosen range must reach. The threshold at which a vehicle takes a
// second look is set by passes/localize/calibrate_plan.h.

namespace sightline {

struct CalibrationOptions {
  RiskControl risk_control = RiskControl::kConformal;
  double alpha = 0.05;
  double delta = 0.1;
  double fixed_threshold = 0.8;
  double dilation_m = 3.0;
  // Of the model's sites, where looks are chosen by kind of place; null: each site's own, by the
  // rule.
  const std::vector<std::uint8_t>* look_of_site = nullptr;
  std::optional<ThresholdGroup> group = {};  // whose cases are counted; none: all
};

// One limit calibrated on the model's own sites.
struct Calibration {
  LimitPromise promise;
  Choice choice;               // of the model's sites, at the threshold
  std::size_t case_count = 0;  // that were counted
};

// Sets p* of one limit for one kind of case by applying the probability rule, with dilation and
// with `tighter` (the choice for the next tighter limit; null for the tightest) as cap, to the
// model's out-of-fold predictions, and counting answers (sites not flagged kUnmet) and misses among
// them block by block. A promise is earned only where they were counted on drives that the trees
// did not learn from (passes/model/promise/calibration_drives.h); elsewhere the threshold is kept,
// and the statement says that it is of this drive. Thresholds tried: 0.7 (kLeastProbability),
// 0.705, ..., 1.
Calibration calibrate_probability(const ErrorModel& model, std::size_t limit, CaseKind kind,
                                  const CalibrationOptions& options, const Choice* tighter);

// What the mean rule reached out of fold; it promises nothing.
LimitPromise assess_mean_rule(const ErrorModel& model, std::size_t limit);

}  // namespace sightline
