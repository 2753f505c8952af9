#pragma once

#include "formats/annotation/measured_error.h"
#include "formats/annotation/range_table.h"
#include "formats/base/result.h"
#include "formats/evaluation/look_evaluation.h"

namespace sightline {

// Judges the looks that a map chose, those that take a sample, on a drive that was measured at
// them first and then at any others: these stand beside them as baselines. `judged` is of the
// ranges, whose last is what all is compared with; both have of_samples. At least one site was
// measured. Error: mismatched-inputs where the drive was measured at other looks.
Result<LookEvaluation> evaluate_looks(const RangeTable& ranges, const MeasuredError& judged);

}  // namespace sightline
