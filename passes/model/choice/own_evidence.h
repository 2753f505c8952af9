#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/grid/site_shape.h"
#include "formats/model/error_model.h"
#include "formats/tables/stored_table.h"

// How well each range localizes in a street by errors measured in that street itself, or simulated
// there, and a model of these errors alone.

namespace sightline {

struct OwnEvidence {
  std::vector<Look> looks;  // from the cheapest to the dearest
  std::uint32_t site_count = 0;
  // [site][range]: the error of the map's own scan. After add_measured() also the error of a drive
  // that the model was trained on, where that is larger.
  std::vector<double> error_m;
  std::vector<double> cost;  // [site][range]: of one match, in points; in metres of range where
                             // the factors have neither match_cost nor virtual_points

  bool is_simulated = false;  // no scan of a drive is behind it

  [[nodiscard]] SiteShape shape() const { return {looks.size()}; }
};

// Of the factors' column `own_error`; where there is none `mapping_error`, then `virtual_error`.
// Error: mismatched-inputs where the table has none of the three.
Result<OwnEvidence> own_evidence_of(const FactorTable& factors);

// Stretch by stretch. Errors: cannot-read, and the same.
Result<OwnEvidence> own_evidence_of(const StoredTable<FactorTable>& all);

// Where the model learnt from these very sites, the errors that its drive measured there count
// wherever they are larger: the map's own scans helped to make it, and are optimistic.
void add_measured(const Sites& sites, const PredictedError& predicted, const ErrorModel& model,
                  OwnEvidence& evidence);

// The same for a localizer that is not the one which found it: all that is believed is the longest
// range.
OwnEvidence for_another_localizer(OwnEvidence evidence);

// How a choice fares by that evidence.
struct Standing {
  double coverage = 0.0;  // share of sites whose own error is within the limit at their range
  double cost = 0.0;      // mean over sites
};
Standing standing_of(const OwnEvidence& evidence, double limit_m,
                     const std::vector<std::uint8_t>& range_index);

// One range for the whole street.
struct StaticAnswer {
  std::uint8_t range_index = 0;
  Standing standing;
};

// The cheapest that covers at least `least_coverage` by the evidence; where none does, the one that
// covers most, the cheapest of these; where none covers any site, the one of least mean error. Of
// equal costs or errors the shortest range.
StaticAnswer best_static(const OwnEvidence& evidence, double limit_m, double least_coverage);

// For a drive too short to learn from: a model that predicts the errors of the map's own scans at
// each range for every site. Its labels are these errors; its card has no folds and one block, so
// that nothing is promised on it, and its R^2 is 0 at most: choose-ranges takes the street's static
// answer. Errors: those of own_evidence_of; no-training-rows where there are no sites.
Result<ErrorModel> model_of_own_evidence(const Sites& sites, const FactorTable& factors,
                                         const MeasuredError& measured,
                                         const RecordingCards& recordings,
                                         const std::vector<double>& limits_m);

}  // namespace sightline
