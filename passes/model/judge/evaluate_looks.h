#pragma once

#include "formats/annotation/measured_error.h"
#include "formats/annotation/range_table.h"
#include "formats/base/result.h"
#include "formats/evaluation/look_evaluation.h"

namespace sightline {

// Judges the looks that a map chose, those that take a sample, on a drive that was measured at
// them first and then at any others: these stand beside them as baselines. All is
// compared with the last range of `judged`, which has samples. At least one site was measured.
// Error: mismatched-inputs where the drive was measured at other looks.
Result<LookEvaluation> evaluate_looks(const RangeTable& choice,
                                      const ByFamily<MeasuredError>& judged);

}  // namespace sightline
