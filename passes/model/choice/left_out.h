#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// A drive whose errors no prediction here used: what is predicted from the others, and what it
// measured.
struct LeftOutDrive {
  PredictedError predicted;
  MeasuredError measured;
};

// One element for each independent drive in the factors' columns
// (passes/model/forest/measured_columns.h): the prediction from all other drives there, and the
// errors of this one. So each drive is left out once, as in training. Empty if there are fewer than
// two drives, or the model was trained without history. Errors: those of predict_error.
Result<std::vector<LeftOutDrive>> leave_out_in_turn(const PassContext& ctx, const ErrorModel& model,
                                                    const Sites& sites, const FactorTable& factors,
                                                    double support_margin);

// The same by the looks that take a sample; none unless all know them.
std::vector<LeftOutDrive> samples_of(const std::vector<LeftOutDrive>& drives);

}  // namespace sightline
