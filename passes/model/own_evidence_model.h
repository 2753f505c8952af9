#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"

namespace sightline {

// For a drive too short to learn from: a model that knows one thing, how the map's own scans end at
// each range (passes/model/choice/own_evidence.h), and says it of every site. Its labels are their
// errors; its card has no folds and one block, so that nothing is promised on it, and its R^2 is 0
// at most: choose-ranges takes the street's static answer. Errors: those of own_evidence_of;
// no-training-rows where there are no sites.
Result<ErrorModel> model_of_own_evidence(const Sites& sites, const FactorTable& factors,
                                         const MeasuredError& measured,
                                         const RecordingCards& recordings,
                                         const std::vector<double>& limits_m);

}  // namespace sightline
