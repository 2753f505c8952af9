#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_drives.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/predicted_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/recording_cards.h"
#include "formats/model/error_model.h"
#include "formats/tables/stored_table.h"
#include "passes/model/forest/history.h"
#include "passes/pass/pass.h"

namespace sightline {

// A map whose sites are predicted, by the looks of a family.
struct PredictedSites {
  const Sites& sites;
  const StoredTable<FactorTable>& factors;
  const RecordingCards& recordings;

  [[nodiscard]] Eigen::Vector3d place_of(std::size_t site) const {
    return sites.frame.origin_world_m + sites.sites[site].p_map_m;
  }
};

enum class HistoryUse { kAuto, kNever };

struct PredictErrorOptions {
  // A feature counts as known up to this share of the training's spread outside its extremes.
  double support_margin = 0.25;
  // auto: what a localization drive measured here is history to a model made elsewhere.
  HistoryUse history = HistoryUse::kAuto;
};
std::vector<OptionField> option_fields(PredictErrorOptions& options);

// What the model predicts for every site at every range: mean error, and P(error <= limit) for the
// model's limits. A site that the model was trained on (same place to a millimetre, same factors of
// ranges and of looks that take a sample) gets its out-of-fold prediction, since the whole forest
// remembers its error; all others that of the whole forest. A site is extrapolated at a range where
// more than half of what the forest decides by lies outside the support
// (Support). `recordings` made this map. Sites that are not the model's own
// but lie within its buffer of them, in a place that the model knows from one of these recordings
// or in coordinates of the world (more than 100 km from where recordings without any begin), are
// counted in a warning: their predictions may be optimistic.
//
// Earlier drives on this map are `history`, one drive, or `drives`, several, or neither: what they
// measured within 6 m of a site is among the site's features (schemas/definitions.md, "Measured
// history"). A model that was trained without history ignores it, and so does one of another
// localizer; a warning says so.
//
// Errors: mismatched-inputs where sites, factors, history and model differ in count, ranges or
// factors; invalid-artifact for a factor that is not finite.
Result<ByFamily<PredictedError>> predict_error(PassContext& ctx, const PredictErrorOptions& options,
                                               const ByFamily<ErrorModel>& model,
                                               const Sites& sites,
                                               const ByFamily<StoredTable<FactorTable>>& factors,
                                               const RecordingCards& recordings,
                                               const ByFamily<MeasuredError>* history = nullptr,
                                               const MeasuredDrives* drives = nullptr);
inline constexpr Pass kPredictError =
    Pass{"predict-error", 5, "predicted", "Predicted errors of each site", &predict_error}.in(
        Stage::kLearn);

// Of one family, by one model. Sites of its training get their out-of-fold predictions. `history`:
// inputs of the model, may be none. Errors: those of predict-error.
Result<PredictedError> predict_looks(const PassContext& ctx, double support_margin,
                                     const ErrorModel& model, const PredictedSites& sites,
                                     const EarlierDrives& history);

}  // namespace sightline
