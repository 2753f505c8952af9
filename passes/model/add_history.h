#pragma once

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_drives.h"
#include "formats/annotation/predicted_error.h"
#include "formats/drive/recording_cards.h"
#include "formats/model/error_model.h"
#include "passes/pass/pass.h"

namespace sightline {

// The factors, and beside them what each of several drives measured, where the predictions were
// inputs were: so they can be made again from the map (passes/model/forest/measured_columns.h).
// A drive is independent whose recording is named once, and is behind neither the map nor a place
// that the model learnt from. Error: mismatched-inputs where factors and errors are of different
// sites or looks.
Result<ByFamily<FactorTable>> add_history(PassContext& ctx, const NoOptions& options,
                                          const ByFamily<FactorTable>& factors,
                                          const MeasuredDrives& measured,
                                          const ByFamily<PredictedError>& predicted,
                                          const ByFamily<ErrorModel>& model,
                                          const RecordingCards& recordings);
inline constexpr Pass kAddHistory = Pass{"add-history", 4, "factors-with-history",
                                         "Measured history of several drives", &add_history}
                                        .in(Stage::kLearn);

}  // namespace sightline
