#include "compiler/driver/pipelines.h"

#include <algorithm>
#include <utility>

#include "passes/emit/emit_map.h"
#include "passes/factors/factors_of_sites.h"
#include "passes/ingest/ingest.h"
#include "passes/ingest/ingest_compiled_map.h"
#include "passes/ingest/ingest_map.h"
#include "passes/ingest/join_drives.h"
#include "passes/ingest/join_sensors.h"
#include "passes/localize/add_mapping_error.h"
#include "passes/localize/calibrate_plan.h"
#include "passes/localize/import_errors.h"
#include "passes/localize/join_errors.h"
#include "passes/localize/measure_error.h"
#include "passes/localize/simulate_error.h"
#include "passes/localize/site_localizer.h"
#include "passes/localize/track_drive.h"
#include "passes/map/build_nd_surface.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "passes/map/choose_sites.h"
#include "passes/map/places/choose_field_sites.h"
#include "passes/map/places/choose_route_sites.h"
#include "passes/map/remove_moving.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/model/add_history.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/judge/evaluate_ranges.h"
#include "passes/model/predict_error.h"
#include "passes/model/train_model.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "passes/trajectory/align_drive.h"
#include "passes/trajectory/align_later_drive.h"
#include "passes/trajectory/complete_trajectory.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/released/extend_released.h"
#include "passes/trajectory/undistort_scans.h"

namespace sightline {
namespace {

// Which scans of the mapping drive make the map, and which are localized in it.
struct ScanShares {
  ScanSelection mapping = ScanSelection::kAll;
  ScanSelection localization = ScanSelection::kAll;
};

ScanShares scan_shares(const CompileConfig& config) {
  return config.is_split() ? ScanShares{ScanSelection::kEven, ScanSelection::kOdd} : ScanShares{};
}

// Looks that take a sample are matched by this program's own localizers.
MeasureErrorOptions measuring_options(const CompileConfig& config, const Plan& plan) {
  MeasureErrorOptions options = plan.options(kMeasureError);
  const bool is_own = options.localizer != LocalizerKind::kPclNdt && !config.imports_errors();
  if (!is_own) options.looks.clear();
  return options;
}

// The looks of a map first, then those that need none.
std::vector<Look> with_baselines(std::vector<Look> looks) {
  for (const Look& look : baseline_looks()) {
    if (std::ranges::find(looks, look) == looks.end()) looks.push_back(look);
  }
  return looks;
}

// A map that a drive is measured in, and how.
struct OnMap {
  Plan& plan;
  Wire<NdtMap> ndt;
  Wire<Sites> sites;
  MeasureErrorOptions measuring;
};

RecordingInput add_recording(Plan& plan, const std::string& role, const RecordingOptions& options) {
  return {role, options, plan.input<Recording>(role + "/recording"),
          plan.input<SensorProfile>(role + "/sensor")};
}

// Its errors as a localizer outside made them, where `file` names them; else as ours makes them.
Wire<MeasuredError> add_errors(const CompileConfig& config, std::string_view label,
                               const LocalizedDrive& drive, const OnMap& on,
                               std::vector<OutsideInput>& outside) {
  Plan& plan = on.plan;
  const bool is_evaluation = label == "evaluation";
  const std::string& file = is_evaluation ? config.outside.evaluation_file : config.outside.file;
  if (file.empty()) {
    return plan.run_as(label, kMeasureError, on.measuring, drive.undistorted, drive.trajectory,
                       on.ndt, on.sites);
  }
  const std::string role = is_evaluation ? "evaluation" : "localization";
  outside.push_back({file, config.outside, plan.input<OutsideErrors>(role + "/outside-errors")});
  const ImportErrorsOptions importing{on.measuring.ranges_m, on.measuring.scans,
                                      on.measuring.site_radius_m};
  return plan.run_as(label, kImportErrors, importing, outside.back().errors, drive.drive,
                     drive.trajectory, on.sites);
}

// What makes the map: the scans of all sensors on the vehicle, and a pose for each.
struct MappingDrive {
  Wire<Drive> drive;
  Wire<Trajectory> trajectory;
};

// Joins the scans of the vehicle's other sensors to those of the first, one sensor after the other.
MappingDrive with_other_sensors(const CompileConfig& config, const MappingDrive& first,
                                CompilePlan& compile) {
  Plan& plan = compile.plan;
  MappingDrive joined = first;
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    if (config.other_sensors[i].scans.empty()) continue;
    const std::string role = other_sensor_section(i);
    compile.recordings.push_back(add_recording(plan, role, config.other_sensors[i]));
    const Wire<Drive> other =
        plan.run_as(role, kIngest, plan.options(kIngest), compile.recordings.back().recording);
    joined.drive = plan.run_as(role, kJoinSensors, {}, joined.drive, other);
  }
  if (joined.drive != first.drive) {
    joined.trajectory = plan.run(kCompleteTrajectory, joined.drive, first.trajectory);
  }
  return joined;
}

// Joins the other drives that make the map to the first.
Wire<Drive> with_later_drives(const CompileConfig& config, Wire<Drive> drive,
                              CompilePlan& compile) {
  Plan& plan = compile.plan;
  for (std::size_t i = 0; i < config.later_mapping.size(); ++i) {
    const std::string role = later_mapping_role(i);
    compile.recordings.push_back(add_recording(plan, role, config.later_mapping[i]));
    const Wire<Drive> later =
        plan.run_as(role, kIngest, plan.options(kIngest), compile.recordings.back().recording);
    drive = plan.run_as(role, kJoinDrives, {}, drive, later);
  }
  return drive;
}

// Where the mapping drives were; beside an earlier map, where that left them.
void add_trajectory(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.base_file = config.base_poses;
  if (compile.base_file.empty()) {
    compile.trajectory = plan.run(kEstimateTrajectory, compile.drive);
  } else {
    compile.base = plan.input<ReleasedPoses>("base/released-poses");
    compile.trajectory = plan.run_as("", kExtendReleased, plan.options(kEstimateTrajectory),
                                     compile.drive, compile.base);
  }
  if (config.later_mapping.empty() && compile.base_file.empty()) return;
  compile.released = plan.run(kReleasePoses, compile.drive, compile.trajectory);
}

// The steps of a drive that is localized in a map. `aligning`: kAlignDrive, or that of a drive that
// may be elsewhere.
LocalizedDrive add_drive(Plan& plan, const RecordingInput& input, Wire<NdtMap> ndt,
                         Wire<Sites> sites, decltype(kAlignDrive) aligning = kAlignDrive) {
  const std::string& role = input.role;
  // What a second drive knows of itself, however the first one's poses came about.
  EstimateTrajectoryOptions own_poses = plan.options(kEstimateTrajectory);
  own_poses.mode = EstimateTrajectoryOptions{}.mode;
  LocalizedDrive localized;
  localized.drive = plan.run_as(role, kIngest, plan.options(kIngest), input.recording);
  const Wire<Trajectory> own = plan.run_as(role, kEstimateTrajectory, own_poses, localized.drive);
  // By the drive's own motion, and before it is laid into the map, which is made of such scans: one
  // that is drawn out lies best on it where it has not been.
  localized.undistorted =
      plan.run_as(role, kUndistortScans, plan.options(kUndistortScans), localized.drive, own);
  // From here on the drive is expressed in the frame of the map.
  localized.trajectory = plan.run_as(role, aligning, plan.options(kAlignDrive),
                                     localized.undistorted, own, ndt, sites);
  return localized;
}

// The errors of the localization drive; where there are several, those of each by itself, joined.
// From here on `measured` speaks for all of them.
void add_localization_errors(const CompileConfig& config, const LocalizedDrive& first,
                             const OnMap& on, CompilePlan& compile) {
  Plan& plan = on.plan;
  compile.measured = add_errors(config, "", first, on, compile.outside);
  for (std::size_t i = 0; i < config.later_localization.size(); ++i) {
    const std::string role = later_localization_role(i);
    compile.recordings.push_back(add_recording(plan, role, config.later_localization[i]));
    const LocalizedDrive later =
        add_drive(plan, compile.recordings.back(), on.ndt, on.sites, kAlignLaterDrive);
    const Wire<MeasuredError> errors =
        plan.run_as(role, kMeasureLaterDrive, on.measuring, later.undistorted, later.trajectory,
                    on.ndt, on.sites);
    Wire<MeasuredDrives>& joined = compile.measured_drives;
    joined =
        i == 0
            ? plan.run_as(role, kJoinErrors, {}, first.drive, later.drive, compile.measured, errors)
            : plan.run_as(role, kJoinMoreErrors, {}, first.drive, later.drive, joined, errors);
  }
  if (compile.measured_drives.is_connected()) {
    compile.measured = plan.run(kPoolErrors, compile.measured_drives);
  }
}

// The map's factors, and what sites see of it, for those who look at that.
Wire<FactorTable> add_factors(Wire<SensorProfile> localizing_sensor, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.depth = plan.run(kCastRays, compile.surface, compile.sites);
  plan.run(kCastScans, compile.surface, compile.sites, localizing_sensor);
  const FactorsOfSitesOptions seeing{plan.options(kComputeFactors).ranges_m,
                                     plan.options(kCastRays), plan.options(kCastScans)};
  return plan.run_as("", kComputeFactors, seeing, compile.ndt, compile.surface, compile.sites,
                     localizing_sensor);
}

// The map: NDs, surface, sites and the paper's factors.
Wire<FactorTable> add_map(const CompileConfig& config, const MappingDrive& mapping,
                          Wire<SensorProfile> localizing_sensor, CompilePlan& compile) {
  Plan& plan = compile.plan;
  RemoveMovingOptions moving = plan.options(kRemoveMoving);
  ChooseSitesOptions route = plan.options(kChooseSites);
  moving.scans = route.scans = scan_shares(config).mapping;
  compile.undistorted = plan.run(kUndistortScans, mapping.drive, mapping.trajectory);
  // From here on a scan is as if it had been measured at once.
  compile.points = plan.run_as("", kRemoveMoving, moving, compile.undistorted, mapping.trajectory);
  // From here on all that is left stood still.
  compile.ndt = plan.run(kBuildNdt, compile.points);
  compile.surface = plan.run(kBuildSurface, compile.points);
  const bool is_one_sensor = mapping.drive == compile.drive;
  compile.sharpness = plan.run(
      kMeasureSharpness, is_one_sensor ? compile.undistorted : compile.drive, compile.trajectory);
  compile.sites = plan.run_as("", kChooseSites, route, compile.drive, compile.trajectory);
  return add_factors(localizing_sensor, compile);
}

// The scans that made the map, localized in it: they have the poses that they made it with. As
// evidence for the choice they are judged as the localization drive is, as a factor by those poses.
// `learns_here`: the model is to learn from the other scans of the same drive.
Wire<FactorTable> add_own_scans(const CompileConfig& config, const LocalizedDrive& mapping,
                                Wire<FactorTable> map_factors,
                                Wire<SensorProfile> localizing_sensor, bool learns_here,
                                CompilePlan& compile) {
  Plan& plan = compile.plan;
  MeasureErrorOptions options = measuring_options(config, plan);
  options.scans = scan_shares(config).mapping;
  // Evidence and a factor, not labels: cheap, at every site, and the same whoever will localize
  // here.
  if (options.localizer == LocalizerKind::kPclNdt) {
    options.localizer = LocalizerKind::kSearching;
    options.starts.count = 0;
  }
  options.site_step = 1;
  const auto measured_as = [&](const std::string& role) {
    return plan.run_as(role, kMeasureError, options, mapping.undistorted, mapping.trajectory,
                       compile.ndt, compile.sites);
  };
  const Wire<MeasuredError> own = measured_as("own");
  // A model that learnt one half of a drive from the other would believe it too much elsewhere.
  if (learns_here) return plan.run(kAddOwnError, map_factors, own);
  const bool are_one = options.reference == ErrorReference::kKnownPose;
  options.reference = ErrorReference::kKnownPose;
  options.is_mapping_drive = true;
  const Wire<MeasuredError> by_pose = are_one ? own : measured_as("mapping");
  return plan.run(kAddMappingError, map_factors, own, by_pose, compile.recordings.front().sensor,
                  localizing_sensor);
}

// The model that annotates the map.
Wire<ErrorModel> add_model(CompilePlan& compile) {
  Plan& plan = compile.plan;
  if (compile.given_model.is_connected()) return compile.given_model;
  if (compile.measured_drives.is_connected()) {
    return plan.run(kTrainModelOfDrives, compile.sites, compile.factors, compile.measured_drives,
                    compile.cards);
  }
  return plan.run(kTrainModelHere, compile.sites, compile.factors, compile.measured, compile.cards);
}

// What it says of each site, told what one drive measured here, or several.
Wire<PredictedError> add_prediction_with_history(CompilePlan& compile) {
  Plan& plan = compile.plan;
  if (compile.measured_drives.is_connected()) {
    return plan.run(kPredictErrorWithDrives, compile.model, compile.sites, compile.factors,
                    compile.measured_drives, compile.cards);
  }
  return plan.run(kPredictErrorWithHistory, compile.model, compile.sites, compile.factors,
                  compile.measured, compile.cards);
}

// The model that annotates the map, and what it says of each site. Returns the factors as the map
// keeps them.
Wire<FactorTable> add_choice(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const bool is_given = compile.given_model.is_connected();
  compile.model = add_model(compile);
  // What was simulated is no history.
  const bool is_measured = compile.measured != compile.simulated;
  const bool has_history =
      is_given && is_measured && config.passes.options(kPredictError).history == HistoryUse::kAuto;
  compile.predicted = has_history ? add_prediction_with_history(compile)
                                  : plan.run(kPredictError, compile.model, compile.sites,
                                             compile.factors, compile.cards);
  // From here on every site's prediction comes from trees that never saw its place.
  compile.ranges =
      plan.run(kChooseRanges, compile.sites, compile.predicted, compile.model, compile.factors);
  compile.evaluation = plan.run(kEvaluateRanges, compile.sites, compile.predicted, compile.ranges,
                                compile.factors, compile.measured);
  const bool is_of_several = has_history && compile.measured_drives.is_connected();
  return is_of_several
             ? plan.run(kAddHistory, compile.factors, compile.measured_drives, compile.predicted)
             : compile.factors;
}

// NDs and surface of a finished map.
void add_surroundings(CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  if (finished.options.is_compiled()) {
    finished.compiled = plan.input<CompiledMap>("map/compiled-map");
    compile.ndt = plan.run(kIngestCompiledMap, finished.compiled);
    compile.surface = plan.run(kBuildNdSurface, compile.ndt);
    return;
  }
  finished.points = plan.input<PointMap>("map/point-map");
  compile.points = plan.run(kIngestMap, finished.points);
  // All points are taken for what stood still; nobody knows from where they were seen.
  compile.ndt = plan.run(kBuildNdt, compile.points);
  compile.surface = plan.run(kBuildSurface, compile.points);
}

// The places of a finished map that are annotated.
Wire<Sites> add_places(CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  if (finished.route_options.is_everywhere()) {
    return plan.run(kChooseFieldSites, compile.surface, compile.localizing_sensor);
  }
  finished.route = plan.input<Route>("route");
  return plan.run(kChooseRouteSites, finished.route, compile.surface, compile.localizing_sensor);
}

// NDs and surface of a finished map, the places along its route, and what simulated scans tell of
// them.
void add_finished_map(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  finished.options = config.map;
  finished.route_options = config.route;
  finished.world = config.annotation.world;
  finished.sensor = plan.input<SensorProfile>("map/sensor");
  if (!config.localization.scans.empty()) {
    compile.recordings.push_back(add_recording(plan, "localization", config.localization));
    compile.localizing_sensor = compile.recordings.back().sensor;
  } else {
    compile.localizing_sensor = finished.sensor;
  }
  add_surroundings(compile);
  compile.sites = add_places(compile);
  const Wire<FactorTable> map_factors = add_factors(compile.localizing_sensor, compile);
  SimulateErrorOptions simulating = plan.options(kSimulateError);
  simulating.matching = measuring_options(config, plan);
  // Evidence and a factor, as of the scans that make a map: at every site, by this program's own.
  if (simulating.matching.localizer == LocalizerKind::kPclNdt) {
    simulating.matching.localizer = LocalizerKind::kSearching;
    simulating.matching.starts.count = 0;
  }
  compile.simulated = plan.run_as("", kSimulateError, simulating, compile.surface, compile.ndt,
                                  compile.sites, compile.localizing_sensor);
  compile.factors = plan.run(kAddSimulatedError, map_factors, compile.simulated);
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
  // From here on places that a drive passed have been measured; the others stay simulated.
  const Wire<FactorTable> factors = add_choice(config, compile);
  compile.map = compile.finished.compiled.is_connected()
                    ? plan.run(kEmitMapAnew, compile.ndt, compile.sites, compile.predicted,
                               compile.ranges, compile.measured, compile.model, factors,
                               compile.localizing_sensor, compile.cards, compile.finished.compiled)
                    : plan.run(kEmitAnnotatedMap, compile.ndt, compile.sites, compile.predicted,
                               compile.ranges, compile.measured, compile.model, factors,
                               compile.localizing_sensor, compile.cards);
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
  LocalizedDrive localized{compile.drive, compile.trajectory, compile.undistorted};
  if (mapping.drive != compile.drive) {
    localized.undistorted =
        plan.run_as("first-sensor", kUndistortScans, plan.options(kUndistortScans), compile.drive,
                    compile.trajectory);
  }
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
  CalibratePlanOptions tracking = plan.options(kCalibratePlan);
  tracking.matching = measuring;
  tracking.reach_m = plan.options(kEmitMap).reach_m;
  compile.look_plan = plan.run_as("", kCalibratePlan, tracking, localized.undistorted,
                                  localized.trajectory, compile.ndt, compile.sites, compile.ranges);
  EmitMapOptions emitting = plan.options(kEmitMap);
  emitting.mapping_scans = scan_shares(config).mapping;
  compile.map =
      plan.run_as("", kEmitMap, emitting, compile.drive, localized.drive, compile.ndt,
                  compile.sites, compile.predicted, compile.ranges, compile.measured, compile.model,
                  factors, compile.look_plan, compile.sharpness, compile.trajectory);
  return compile;
}

std::vector<AnyWire> told_of(const CompilePlan& compile) {
  std::vector<AnyWire> told = {compile.map, compile.measured, compile.ranges, compile.factors,
                               compile.evaluation};
  if (compile.sharpness.is_connected()) told.push_back(compile.sharpness);
  if (compile.released.is_connected()) told.push_back(compile.released);
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
  const bool is_same_recording =
      config.is_split() && config.evaluation.scans == config.mapping.scans;
  measuring.scans = is_same_recording ? ScanSelection::kOdd : ScanSelection::kAll;
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

std::vector<ConfigSection> published_sections(CompileConfig& config) {
  // With every pass that a compile or an evaluation may run.
  CompileConfig complete;
  complete.localization.scans = "any";
  CompileConfig finished = complete;
  finished.map.points = "any";
  CompileConfig everywhere = finished;
  everywhere.route.file = RouteOptions::kEverywhere;
  complete.other_sensors.front().scans = "any";
  complete.later_mapping.resize(1);
  complete.later_mapping.front().scans = "any";
  std::vector<ConfigSection> sections = drive_sections(config);
  for (const Plan& plan :
       {compile_plan(complete).plan, compile_plan(finished).plan, compile_plan(everywhere).plan,
        evaluate_plan(complete, CompiledMap{}).plan}) {
    for (ConfigSection& pass : sections_of(plan)) {
      if (std::ranges::find(sections, pass.name, &ConfigSection::name) != sections.end()) continue;
      sections.push_back(std::move(pass));
    }
  }
  sections.push_back(gate_section());
  return sections;
}

Result<CompileConfig> load_compile_config(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides) {
  CompileConfig config;
  SIGHTLINE_TRY(read_compile_config(file, overrides, published_sections(config), config));
  return config;
}

Result<CompileConfig> compile_config_of(const std::vector<std::string>& overrides) {
  return load_compile_config({}, overrides);
}

}  // namespace sightline
