#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "formats/annotation/range_table.h"
#include "passes/model/choice/leave_one_drive_out.h"
#include "passes/model/choice/looks_of_kinds.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/promise/calibration.h"
#include "passes/model/promise/selection.h"
#include "passes/pass/options.h"

// The choices of choose-ranges, limit after limit, each with its promise.

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

  // `look_of_site`: as in CalibrationOptions.
  LimitPromise next(CaseKind kind, std::size_t limit,
                    const std::vector<std::uint8_t>* look_of_site = nullptr) {
    options_.look_of_site = look_of_site;
    std::optional<Choice>& tighter = tighter_[static_cast<std::size_t>(kind)];
    Calibration calibration =
        calibrate_probability(model_, limit, kind, options_, tighter ? &*tighter : nullptr);
    tighter = std::move(calibration.choice);
    return calibration.promise;
  }

 private:
  const ErrorModel& model_;
  CalibrationOptions options_;
  std::optional<Choice> tighter_[2];  // of the model's sites, by kind
};

// What choices are made of.
struct ChoiceInputs {
  const Sites& sites;
  const PredictedError& predicted;
  const ErrorModel& model;
  const OwnEvidence& evidence;
  const std::vector<LeftOutDrive>& left_out;  // none where fewer than two drives are known
  const LookEvidence* looks = nullptr;        // of looks that take a sample
  const MeasuredError* measured = nullptr;  // of the compile's own drives; null: none was measured
};

struct Chosen {
  std::vector<LimitPromise> promises;
  std::vector<Choice> choices;  // [limit], of the map's sites
};

// By the rules in choices.cpp, which are listed there in their order.
Chosen choose_all(const ChooseRangesOptions& options, const ChoiceInputs& inputs);

}  // namespace sightline
