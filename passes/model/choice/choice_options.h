#pragma once

#include <vector>

#include "formats/annotation/range_table.h"
#include "passes/pass/options.h"

namespace sightline {

// Of choose-ranges.
struct ChooseRangesOptions {
  Selection selection = Selection::kProbability;  // kMean: the paper's rule
  RiskControl risk_control = RiskControl::kConformal;
  double alpha = 0.0;                  // share of misses that is allowed; 0: of ranges 5 %,
                                       // of looks that take a sample as CalibrationOptions says
  double delta = 0.1;                  // learn-then-test: how often the promise may fail
  double probability_threshold = 0.8;  // p* of "fixed"
  double dilation_m = 3.0;
  bool extrapolated_takes_static = true;
};
std::vector<OptionField> option_fields(ChooseRangesOptions& options);

}  // namespace sightline
