#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/evaluation/evaluation.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/pass.h"

namespace sightline {

struct EvaluateRangesOptions {
  double stretch_m = 100.0;  // of route, for the worst stretch
  // The probability rule's row of a map whose own ranges come from the mean rule.
  double probability_threshold = 0.8;
  double dilation_m = 3.0;
};
std::vector<OptionField> option_fields(EvaluateRangesOptions& options);

// Judges a map's ranges, and the rules they could have come from, on a drive
// (formats/evaluation/evaluation.h; schemas/definitions.md, "Judging a choice"). The rows of both
// rules are worked out from `predicted` alone, without the map's treatment of extrapolated sites;
// the probability rule takes the map's own p* and dilation where it has them. The worst stretch is
// that of `stretch_m` of consecutive judged sites of one run, or the longest run's where none is as
// long. Kinds of place are computed from `factors`, which may be without any. Errors:
// mismatched-inputs where the inputs differ in sites, ranges or limits; no-overlap where the drive
// has no scan near any site.
Result<Evaluation> evaluate_ranges(PassContext& ctx, const EvaluateRangesOptions& options,
                                   const Sites& sites, const ByFamily<PredictedError>& predicted,
                                   const ByFamily<RangeTable>& ranges,
                                   const ByFamily<StoredTable<FactorTable>>& factors,
                                   const ByFamily<MeasuredError>& judged);
inline constexpr Pass kEvaluateRanges =
    Pass{"evaluate-ranges", 5, "evaluation", "Evaluating the choice", &evaluate_ranges}.in(
        Stage::kLearn);

}  // namespace sightline
