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

// Of the drives that lie in the factors' columns (passes/model/forest/measured_columns.h) each one
// that is independent, in turn: n drives are n cases, as in training. None of fewer than two
// drives, and of a model that knows no history. Errors: those of predict_error.
Result<std::vector<LeftOutDrive>> leave_out_in_turn(const PassContext& ctx, const ErrorModel& model,
                                                    const Sites& sites, const FactorTable& factors,
                                                    double support_margin);

// The same by the looks that take a sample; none unless all know them.
std::vector<LeftOutDrive> samples_of(const std::vector<LeftOutDrive>& drives);

}  // namespace sightline
