#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "formats/tables/stored_table.h"
#include "passes/model/choice/choice_options.h"
#include "passes/pass/pass.h"

namespace sightline {

// How far to look at every site, for each limit of the model (schemas/definitions.md, "Error model
// and choice of range"). All rules, in their order: passes/model/choice/choices.cpp.
//
// `mean`: the shortest range whose predicted mean error is within the limit. `probability`: the
// shortest with P(error <= limit) >= p*; if no range is good enough, the most probable, flagged
// kUnmet. Sites whose own answer is extrapolated are flagged, and take the street's static answer
// (passes/model/choice/own_evidence.h, with a coverage of 1 - alpha, 95 % where alpha controls
// nothing) unless options say otherwise. Then, by probability, dilation: a site takes the longest
// range among the neighbours of its run within dilation_m. Looks that take a sample are chosen by
// the same rules.
//
// p* is set per limit, and apart for sites with measured history, by controlling the share of
// misses of this very rule, dilation included, on the model's out-of-fold predictions of the sites
// it has labels for; a site that misses does so whether it was flagged or not. A promise is about
// the next drive, and is made only where p* was set on drives that the trees did not learn from
// (PromiseScope). A promise that too few or too small blocks cannot earn is not made: p* is then
// the least at which the misses seen stay within alpha, and the statement says what is missing. A
// model of one place promises nothing in another.
//
// Where the factors contain the errors of two drives or more (add-history), the choice at sites
// with history is set by these drives, each left out in turn
// (passes/model/choice/leave_one_drive_out.h). All other choices by probability have a floor
// (passes/model/choice/floor.h): where the model explains nothing out of fold, or the static answer
// is cheaper and covers as much by the errors of the map's own scans, that answer is taken at all
// sites, flagged kStatic, and nothing is promised. Last, a looser limit never looks further than a
// tighter one.
//
// In a map without scans (FactorTable's column `simulated`) sites are flagged kSimulatedAnswer
// unless a drive was measured there since, and nothing is promised by a model that did not learn
// from such maps. Errors: mismatched-inputs where sites, predictions, model and factors differ in
// count, ranges or limits, or the factors contain no errors of the map's own scans.
Result<RangeTable> choose_ranges(PassContext& ctx, const ChooseRangesOptions& options,
                                 const Sites& sites, const PredictedError& predicted,
                                 const ErrorModel& model, const StoredTable<FactorTable>& factors);
inline constexpr Pass kChooseRanges =
    Pass{"choose-ranges", 14, "ranges", "How far to look", &choose_ranges}.in(Stage::kLearn);

// What a model can promise of places like its own, a sentence for each limit and kind of site;
// nothing under the mean rule.
std::vector<std::string> promises_of(const ChooseRangesOptions& options, const ErrorModel& model);

}  // namespace sightline
