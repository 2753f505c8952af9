#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "passes/model/choice/own_evidence.h"
#include "passes/model/promise/selection.h"
#include "passes/pass/pass_context.h"

// What the drives of a street, each left out in turn, say of a rule: evidence of the next drive,
// where the map's own scans are optimistic.

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
Result<std::vector<LeftOutDrive>> leave_out_in_turn(const PassContext& ctx,
                                                    const ByFamily<ErrorModel>& model,
                                                    const Sites& sites, const FactorTable& factors,
                                                    double support_margin);

struct DriveVoteOptions {
  double limit_m = 0.1;
  double coverage = 0.95;    // that an answer must reach on the drives left out
  bool is_promised = false;  // the rule at `threshold` comes with a promise
  double threshold = 0.0;    // p* of sites with history
  double alpha = 0.05;       // of that promise
  double block_count = 0.0;  // of route, 60 m each
};

// The choice of the rule for sites with history at a threshold, from one drive's predictions.
using RuleAt = std::function<Choice(const PredictedError& predicted, double threshold)>;

struct DriveVote {
  double threshold = 0.0;                  // of the rule, at sites with history
  std::optional<std::uint8_t> everywhere;  // in its place one range at all of them
  bool keeps_promise = true;
  // Over the cases, the sites of a drive left out that others drove by; coverage of the rule: over
  // those that it answers.
  Standing standing;
  std::size_t case_count = 0;
  std::size_t drive_count = 0;
};

// The cheapest answer that covers `coverage`: the rule, of the cases that it answers (not flagged
// kUnmet), at the least of tried_thresholds() that covers as much; or the best static answer, of
// all cases. Where no answer reaches it, the one that covers most is taken. A promise is kept, at a
// threshold no less strict than its own, unless another answer is cheaper by more than a tenth and
// proven (passes/model/choice/floor.h). Nothing where there are no cases.
std::optional<DriveVote> leave_one_drive_out(std::span<const LeftOutDrive> left_out,
                                             const OwnEvidence& evidence,
                                             const DriveVoteOptions& options,
                                             const RuleAt& rule_at);

}  // namespace sightline
