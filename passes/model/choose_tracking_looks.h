#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_drives.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/recording_cards.h"
#include "formats/model/error_model.h"
#include "formats/model/tracking_looks.h"
#include "formats/tables/stored_table.h"
#include "passes/model/choice/choices.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ChooseTrackingLooksOptions {
  ChooseRangesOptions choice;    // those of choose-ranges
  double support_margin = 0.25;  // that of predict-error
};
std::vector<OptionField> option_fields(ChooseTrackingLooksOptions& options);

// The model of the errors from tracking starts: the same trees and inputs, with these labels in the
// leaves. `model` has such labels. The labels of its forest do not ascend.
ErrorModel tracking_model(const ErrorModel& model);

// By which look a vehicle that tracks localizes at every site, for each limit of the model
// (schemas/definitions.md, "Looks while tracking"): choose-ranges for looks that take a sample,
// with predictions and labels from tracking starts. Looks of kinds of place are chosen by the
// errors of `measured` from such starts; where there are none, by those of the model's own sites.
// `history` and `drives`: as in predict-error. No columns where the model has no labels from
// tracking starts, and under the mean rule. Errors: those of predict-error and choose-ranges.
Result<TrackingLooks> choose_tracking_looks(
    PassContext& ctx, const ChooseTrackingLooksOptions& options, const Sites& sites,
    const ByFamily<ErrorModel>& model, const ByFamily<StoredTable<FactorTable>>& factors,
    const RecordingCards& recordings, const ByFamily<MeasuredError>* measured = nullptr,
    const ByFamily<MeasuredError>* history = nullptr, const MeasuredDrives* drives = nullptr);
inline constexpr Pass kChooseTrackingLooks =
    Pass{"choose-tracking-looks", 1, "tracking-looks", "Choosing looks for vehicles that track",
         &choose_tracking_looks}
        .in(Stage::kLearn);

}  // namespace sightline
