#pragma once

#include <vector>

#include "formats/annotation/driven_places.h"
#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_drives.h"
#include "formats/annotation/measured_error.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "formats/tables/stored_table.h"
#include "passes/model/forest/training_set.h"
#include "passes/pass/pass.h"

namespace sightline {

enum class TrainingWorlds { kRecorded, kGenerated };

struct TrainModelOptions {
  FeatureSet features = FeatureSet::kAll;
  std::vector<double> limits_m = {0.10, 0.25};
  int trees = 200;
  int least_leaf_rows = 5;
  double feature_share = 0.4;
  int tree_rows = 8000;
  double block_m = 60.0;
  double buffer_m = 25.0;
  int folds = 5;
  HoldOut hold_out = HoldOut::kAuto;
  int most_rows = 100000;  // that one forest learns from
  TrainingWorlds worlds = TrainingWorlds::kRecorded;
};
std::vector<OptionField> option_fields(TrainModelOptions& options);

// Learns the mean localization error from map factors, measured history and range: one forest over
// rows (case of a site with a scan, range; passes/model/forest/training_set.h says which cases
// there are), and out-of-fold predictions of every case by trees that saw nothing within buffer_m
// of its fold (schemas/definitions.md, "Error model and choice of range"). A single place with less
// route than two blocks is judged on shorter ones, which a warning says and the model's card shows.
// Equal inputs, options and seed give equal bytes for any thread count. Factors that never vary are
// named in a warning, and so is a model that knows one place alone. Errors: mismatched-inputs where
// sites, factors and errors are not of one map or lack a factor, or where drives were localized by
// different localizers; invalid-artifact for a factor or error that is not finite;
// no-training-rows; drive-too-short where not even two blocks of 15 m fit, or the buffer leaves a
// fold nothing to learn from; both name the place.
Result<ByFamily<ErrorModel>> train_model(PassContext& ctx, const TrainModelOptions& wanted,
                                         const ByFamily<DrivenPlaces>& places);
inline constexpr Pass kTrainModel = Pass{"train-model", 12, "model", "Error model", &train_model}
                                        .in(Stage::kLearn)
                                        .with({.scan_s = 0.009});

// A model from the one place that it is for, without a warning that it knows no other. `measured`
// is of the drive through that place. Where there are several, they are `drives`: each is a label
// in its turn, so that a promise is about the next drive. Where the place is too short, or no scan
// is near a site, the model is that of passes/model/choice/own_evidence.h, which a warning says; so
// it is where errors were simulated, which teach nothing. Errors: those of train_model.
Result<ByFamily<ErrorModel>> train_model_here(PassContext& ctx, const TrainModelOptions& wanted,
                                              const Sites& sites,
                                              const ByFamily<StoredTable<FactorTable>>& factors,
                                              const ByFamily<StoredTable<MeasuredError>>& measured,
                                              const RecordingCards& recordings,
                                              const MeasuredDrives* drives = nullptr);
inline constexpr Pass kTrainModelHere = variant_of(kTrainModel, &train_model_here);

}  // namespace sightline
