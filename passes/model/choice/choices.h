#pragma once

#include <vector>

#include "formats/annotation/range_table.h"
#include "passes/model/choice/calibrator.h"
#include "passes/model/choice/leave_one_drive_out.h"
#include "passes/model/choice/looks_of_kinds.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/promise/selection.h"

// The choices of choose-ranges, limit after limit, each with its promise.

namespace sightline {

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
