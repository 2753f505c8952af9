#pragma once

#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "formats/tables/stored_table.h"
#include "passes/model/choice/choices.h"
#include "passes/pass/pass.h"

namespace sightline {

// How far to look at every site, and by which look in each kind of place, for each limit of the
// model (schemas/definitions.md, "Error model and choice of range" and "Looks of kinds of place").
// All rules, in their order: passes/model/choice/choices.cpp.
//
// p* is set per limit, and apart for sites with measured history, by controlling the share of
// misses of this very rule, dilation included, on the model's out-of-fold predictions of the sites
// it has labels for. Misses are counted among answered sites: one flagged 'unmet' is not answered,
// and LimitPromise states the share of answered ones. A promise is about the next drive, and is
// made only where p* was set on drives that the trees did not learn from (PromiseScope). A promise
// that too few or too small blocks cannot earn is not made: p* is then fitted to the misses seen
// (passes/model/promise/risk_control.h), and the statement says what is missing. A model of one
// place promises nothing in another.
//
// `measured`: what the drives of this compile found, null where there are none: a promise that it
// contradicts is withdrawn.
//
// Errors: mismatched-inputs where sites, predictions, model and factors differ in count, ranges or
// limits, or the factors contain no errors of the map's own scans.
Result<ByFamily<RangeTable>> choose_ranges(PassContext& ctx, const ChooseRangesOptions& options,
                                           const Sites& sites,
                                           const ByFamily<PredictedError>& predicted,
                                           const ByFamily<ErrorModel>& model,
                                           const ByFamily<StoredTable<FactorTable>>& factors,
                                           const ByFamily<MeasuredError>* measured = nullptr);
inline constexpr Pass kChooseRanges =
    Pass{"choose-ranges", 19, "ranges", "Choosing ranges and looks", &choose_ranges}.in(
        Stage::kLearn);

// What a model can promise of places like its own, a sentence for each limit and kind of site;
// nothing under the mean rule.
std::vector<std::string> promises_of(const ChooseRangesOptions& options, const ErrorModel& model);

}  // namespace sightline
