#include "compiler/driver/pipelines.h"

#include <algorithm>
#include <utility>

#include "compiler/driver/steps_of_drives.h"
#include "compiler/driver/steps_of_map.h"
#include "formats/foreign/recording/same_recording.h"
#include "passes/emit/emit_map.h"
#include "passes/emit/pack_model.h"
#include "passes/ingest/ingest.h"
#include "passes/localize/calibrate_plan.h"
#include "passes/localize/track_drive.h"
#include "passes/model/add_history.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/history_of_map.h"
#include "passes/model/judge/evaluate_ranges.h"
#include "passes/model/train_model.h"
#include "passes/trajectory/undistort_scans.h"

namespace sightline {
namespace {

// The looks of a map first, then those that need none.
std::vector<Look> with_baselines(std::vector<Look> looks) {
  for (const Look& look : baseline_looks()) {
    if (std::ranges::find(looks, look) == looks.end()) looks.push_back(look);
  }
  return looks;
}

// The model that annotates the map.
Wire<ErrorModel> add_model(CompilePlan& compile) {
  Plan& plan = compile.plan;
  if (compile.given_model.is_connected()) return compile.given_model;
  return plan.run(kTrainModelHere, compile.sites, compile.factors, compile.measured, compile.cards,
                  compile.measured_drives);
}

// The model that annotates the map, and what it says of each site. Returns the factors as the map
// keeps them.
Wire<FactorTable> add_choice(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const bool is_given = compile.given_model.is_connected();
  compile.model = add_model(compile);
  // What was simulated is no history; what the map knew before is.
  const bool is_measured =
      compile.measured != compile.simulated || compile.measured_drives.is_connected();
  const bool has_history =
      is_given && is_measured && config.passes.options(kPredictError).history == HistoryUse::kAuto;
  const bool is_of_several = has_history && compile.measured_drives.is_connected();
  Maybe<MeasuredError> history;
  Maybe<MeasuredDrives> drives;
  if (is_of_several) drives = compile.measured_drives;
  if (has_history && !is_of_several) history = compile.measured;
  compile.predicted = plan.run(kPredictError, compile.model, compile.sites, compile.factors,
                               compile.cards, history, drives);
  // From here on every site's prediction comes from trees that never saw its place.
  const Wire<FactorTable> factors =
      is_of_several ? plan.run(kAddHistory, compile.factors, compile.measured_drives,
                               compile.predicted, compile.model, compile.cards)
                    : compile.factors;
  compile.ranges =
      plan.run(kChooseRanges, compile.sites, compile.predicted, compile.model, factors);
  compile.evaluation = plan.run(kEvaluateRanges, compile.sites, compile.predicted, compile.ranges,
                                compile.factors, compile.measured);
  return factors;
}

// What drives found in a compiled map before it is annotated anew, behind those that are localized
// in it now. Only a model that is given hears them: one that learns here has no other drives to
// learn it from.
void add_history_of_map(CompilePlan& compile) {
  const Wire<CompiledMap>& map = compile.finished.compiled;
  if (!map.is_connected() || !compile.given_model.is_connected()) return;
  Plan& plan = compile.plan;
  const HistoryOfMapOptions options{plan.options(kMeasureError).site_radius_m};
  compile.measured_drives =
      plan.run_as("", kHistoryOfMap, options, map, compile.sites, compile.localizing_sensor,
                  compile.measured, compile.measured_drives);
}

// Annotates a finished map.
CompilePlan annotate_plan(const CompileConfig& config, CompilePlan compile) {
  Plan& plan = compile.plan;
  add_finished_map(config, compile);
  // From here on every place of the route is known as one is that a mapping drive passed.
  compile.measured = compile.simulated;
  if (!config.localization.scans.empty()) {
    const LocalizedDrive localized =
        add_drive(plan, compile.recordings.back(), compile.ndt, compile.sites);
    add_localization_errors(config, localized,
                            {plan, compile.ndt, compile.sites, measuring_options(config, plan)},
                            compile);
  }
  add_history_of_map(compile);
  // From here on places that a drive passed have been measured; the others stay simulated.
  const Wire<FactorTable> factors = add_choice(config, compile);
  const Wire<PackedModel> packed_model = plan.run(kPackModel, compile.model);
  const FinishedMapInput& finished = compile.finished;
  compile.map =
      plan.run(kEmitMap, compile.packed_nds, compile.sites, compile.predicted, compile.ranges,
               compile.measured, packed_model, factors, compile.localizing_sensor, compile.cards,
               {}, {}, {}, {}, {}, finished.compiled, finished.nds);
  return compile;
}

}  // namespace

CompilePlan compile_plan(const CompileConfig& config, ModelSource model) {
  CompilePlan compile;
  compile.plan = Plan(config.passes);
  Plan& plan = compile.plan;
  compile.cards = plan.input<RecordingCards>("recordings");
  if (model == ModelSource::kGiven) compile.given_model = plan.input<ErrorModel>("given-model");
  if (config.has_map()) return annotate_plan(config, std::move(compile));
  compile.recordings.push_back(add_recording(plan, "mapping", config.mapping));
  const RecordingInput first = compile.recordings.front();

  compile.drive = plan.run(kIngest, first.recording);
  // From here on points are finite, times rise, and a frame near the drive is chosen.
  compile.drive = with_later_drives(config, compile.drive, compile);
  add_trajectory(config, compile);
  const MappingDrive mapping =
      with_other_sensors(config, {compile.drive, compile.trajectory}, compile);
  // From here on every mapping scan, of any sensor, has a pose in the map frame.
  Wire<SensorProfile> localizing_sensor = first.sensor;
  if (!config.is_split()) {
    compile.recordings.push_back(add_recording(plan, "localization", config.localization));
    localizing_sensor = compile.recordings.back().sensor;
  }
  const Wire<FactorTable> map_factors = add_map(config, mapping, localizing_sensor, compile);
  // From here on the map is done; what follows asks how well a vehicle localizes in it, by its
  // first sensor.
  LocalizedDrive localized{compile.drive, compile.trajectory, compile.of_first_sensor};
  compile.factors = add_own_scans(config, localized, map_factors, localizing_sensor,
                                  config.is_split() && model == ModelSource::kTrained, compile);
  if (!config.is_split()) {
    localized = add_drive(plan, compile.recordings.back(), compile.ndt, compile.sites);
  }
  MeasureErrorOptions measuring = measuring_options(config, plan);
  measuring.scans = scan_shares(config).localization;
  add_localization_errors(config, localized, {plan, compile.ndt, compile.sites, measuring},
                          compile);
  const Wire<FactorTable> factors = add_choice(config, compile);
  // From here on nobody needs the model whole.
  const Wire<PackedModel> packed_model = plan.run(kPackModel, compile.model);
  CalibratePlanOptions tracking = plan.options(kCalibratePlan);
  tracking.matching = measuring;
  tracking.reach_m = plan.options(kEmitMap).reach_m;
  compile.look_plan = plan.run_as("", kCalibratePlan, tracking, localized.undistorted,
                                  localized.trajectory, compile.ndt, compile.sites, compile.ranges);
  EmitMapOptions emitting = plan.options(kEmitMap);
  emitting.mapping_scans = scan_shares(config).mapping;
  compile.map = plan.run_as(
      "", kEmitMap, emitting, compile.packed_nds, compile.sites, compile.predicted, compile.ranges,
      compile.measured, packed_model, factors, localizing_sensor, compile.cards, compile.drive,
      compile.trajectory, compile.sharpness, compile.look_plan, compile.tile_drives, {}, {});
  return compile;
}

std::vector<AnyWire> told_of(const CompilePlan& compile) {
  std::vector<AnyWire> told = {compile.map, compile.measured, compile.ranges, compile.factors,
                               compile.evaluation};
  if (compile.sharpness.is_connected()) told.push_back(compile.sharpness);
  if (compile.ships_poses) told.push_back(compile.released);
  return told;
}

Wire<MeasuredError> measure_evaluation_drive(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.recordings.push_back(add_recording(plan, "evaluation", config.evaluation));
  const LocalizedDrive drive =
      add_drive(plan, compile.recordings.back(), compile.ndt, compile.sites);
  MeasureErrorOptions measuring = measuring_options(config, plan);
  measuring.scans = scan_shares(config).localization;
  return add_errors(config, "evaluation", drive, {plan, compile.ndt, compile.sites, measuring},
                    compile.outside);
}

EvaluatePlan evaluate_plan(const CompileConfig& config, const CompiledMap& map) {
  EvaluatePlan evaluate;
  evaluate.plan = Plan(config.passes);
  Plan& plan = evaluate.plan;
  evaluate.ndt = plan.input<NdtMap>("map/nds");
  evaluate.sites = plan.input<Sites>("map/sites");
  evaluate.predicted = plan.input<PredictedError>("map/predicted");
  evaluate.ranges = plan.input<RangeTable>("map/ranges");
  evaluate.factors = plan.input<FactorTable>("map/factors");
  evaluate.recording = add_recording(plan, "evaluation", config.evaluation);
  const LocalizedDrive drive = add_drive(plan, evaluate.recording, evaluate.ndt, evaluate.sites);
  MeasureErrorOptions measuring = plan.options(kMeasureError);
  measuring.ranges_m = ranges_of(map.predicted.looks);
  measuring.every_return = took_every_return(map.model.localizer);
  measuring.looks.clear();
  for (const PredictedError& samples : map.predicted.of_samples) {
    measuring.looks = with_baselines(samples.looks);
  }
  const bool is_same = config.is_split() && is_same_recording(config.evaluation, config.mapping);
  measuring.scans = is_same ? ScanSelection::kOdd : ScanSelection::kAll;
  evaluate.measured = add_errors(config, "evaluation", drive,
                                 {plan, evaluate.ndt, evaluate.sites, measuring}, evaluate.outside);
  evaluate.evaluation = plan.run(kEvaluateRanges, evaluate.sites, evaluate.predicted,
                                 evaluate.ranges, evaluate.factors, evaluate.measured);
  const bool is_own = measuring.localizer != LocalizerKind::kPclNdt && evaluate.outside.empty();
  if (!is_own) return evaluate;
  TrackDriveOptions tracking = plan.options(kTrackDrive);
  tracking.reach_m = map.reach_m;
  tracking.matching = measuring;
  evaluate.tracks = plan.run_as("", kTrackDrive, tracking, drive.undistorted, drive.trajectory,
                                evaluate.ndt, evaluate.sites, evaluate.ranges);
  return evaluate;
}

TrainPlan train_plan(const CompileConfig& config) {
  TrainPlan train;
  train.plan = Plan(config.passes);
  train.places = train.plan.input<DrivenPlaces>("places");
  train.model = train.plan.run(kTrainModel, train.places);
  return train;
}

}  // namespace sightline
