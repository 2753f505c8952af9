#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "passes/model/choice/choice_options.h"
#include "passes/model/choice/leave_one_drive_out.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/promise/calibration.h"
#include "passes/model/promise/selection.h"

// The choices of choose-ranges, limit after limit, each with its promise.

namespace sightline {

// Calibrates limit after limit, each capped by the choice for the tighter one before it.
class Calibrator {
 public:
  Calibrator(const ErrorModel& model, const ChooseRangesOptions& options)
      : model_(model),
        options_{options.risk_control, options.alpha, options.delta, options.probability_threshold,
                 options.dilation_m} {}

  LimitPromise next(CaseKind kind, std::size_t limit) {
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
};

struct Chosen {
  std::vector<LimitPromise> promises;
  std::vector<Choice> choices;  // [limit], of the map's sites
};

// By the rules in choices.cpp, which are listed there in their order.
Chosen choose_all(const ChooseRangesOptions& options, const ChoiceInputs& inputs);

}  // namespace sightline
