#include "compiler/driver/pipelines.h"

#include <algorithm>

#include "compiler/driver/evaluate_plan.h"
#include "passes/emit/emit_map.h"
#include "passes/emit/pack_layers.h"
#include "passes/factors/factors_of_sites.h"
#include "passes/factors/name_kinds.h"
#include "passes/ingest/identify_recordings.h"
#include "passes/ingest/ingest.h"
#include "passes/ingest/ingest_map.h"
#include "passes/ingest/ingest_nd_map.h"
#include "passes/ingest/join_drives.h"
#include "passes/localize/add_mapping_error.h"
#include "passes/localize/calibrate_plan.h"
#include "passes/localize/join_errors.h"
#include "passes/localize/measure_error.h"
#include "passes/localize/simulate_error.h"
#include "passes/map/build_nd_surface.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "passes/map/choose_nds.h"
#include "passes/map/choose_scans.h"
#include "passes/map/choose_sites.h"
#include "passes/map/count_drives.h"
#include "passes/map/count_removed.h"
#include "passes/map/places/choose_field_sites.h"
#include "passes/map/places/choose_route_sites.h"
#include "passes/map/remove_moving.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/model/add_history.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/choose_tracking_looks.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/history_of_map.h"
#include "passes/model/judge/evaluate_ranges.h"
#include "passes/model/train_model.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "passes/trajectory/complete_trajectory.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/released/extend_released.h"
#include "passes/trajectory/undistort_scans.h"

// The order of passes. compile_plan(), near the end, lists the steps of a compile; the functions
// before it are these steps in the same order, each with what becomes true in it. An
// artifact that a step makes is a wire of CompilePlan; one that a compile of this kind does not
// have is not connected, and passes get null for it.

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

// How localization drives are measured. Looks that take a sample are matched by this program's own
// localizers alone.
MeasureErrorOptions measuring_options(const CompileConfig& config, const Plan& plan) {
  MeasureErrorOptions options = plan.options(kMeasureError);
  const bool is_own = options.localizer != LocalizerKind::kPclNdt && !config.imports_errors();
  if (!is_own) options.looks.clear();
  options.in_small_map = plan.options(kEmitMap).size == MapSize::kPromise;
  options.scans = scan_shares(config).localization;
  return options;
}

// How the map's own scans are measured: evidence and a factor, not labels. So it is cheap, without
// tracking starts, and the same for every localizer.
MeasureErrorOptions evidence_options(const CompileConfig& config, const Plan& plan) {
  MeasureErrorOptions options = measuring_options(config, plan);
  options.scans = scan_shares(config).mapping;
  options.tracking.count = 0;
  if (options.localizer == LocalizerKind::kPclNdt) {
    options.localizer = LocalizerKind::kSearching;
    options.starts.count = 0;
  }
  return options;
}

// Step 1: inputs. A compile has one list of recordings, each with its role; they are opened before
// the plan runs (provide_inputs.h). A split recording is both mapping and localization drive and is
// listed once.

// The evaluation drive is used by `evaluate`, and where a compile is asked for it.
bool is_used(const CompileConfig& config, const RecordingRole& role,
             const RecordingOptions& options) {
  const bool is_named = !options.scans.empty();
  if (role.use == RecordingUse::kMapping) return !config.has_map();
  if (role.use == RecordingUse::kOtherSensor) return !config.has_map() && is_named;
  return role.use == RecordingUse::kLocalization && (is_named || role.number > 0);
}

std::vector<RecordingInput> recordings_for(const CompilePlan& compile, RecordingUse use) {
  std::vector<RecordingInput> found;
  for (const RecordingInput& input : compile.recordings) {
    if (input.use == use) found.push_back(input);
  }
  return found;
}

CompilePlan with_inputs(const CompileConfig& config, ModelSource model) {
  CompilePlan compile;
  compile.plan = Plan(config.passes);
  Plan& plan = compile.plan;
  compile.cards = plan.input<RecordingCards>("recordings");
  if (model == ModelSource::kGiven)
    compile.given_model = plan.input<ByFamily<ErrorModel>>("given-model");
  visit_recordings(config, [&](const RecordingRole& role, const RecordingOptions& options) {
    if (!is_used(config, role, options)) return;
    compile.recordings.push_back(add_recording(plan, role, options));
  });
  for (const RecordingUse use : {RecordingUse::kMapping, RecordingUse::kLocalization}) {
    const std::vector<RecordingInput> drives = recordings_for(compile, use);
    if (!drives.empty()) compile.localizing_sensor = drives.front().sensor;
  }
  return compile;
}

// Step 2: drives. From here on points are finite, times rise, and a frame near the first drive is
// chosen. Several mapping drives become parts of one.

std::vector<Wire<Drive>> ingest_drives(CompilePlan& compile, RecordingUse use) {
  std::vector<Wire<Drive>> drives;
  for (RecordingInput& input : compile.recordings) {
    if (input.use != use) continue;
    input.drive = ingest_drive(compile.plan, input);
    drives.push_back(input.drive);
  }
  return drives;
}

void read_drives(CompilePlan& compile) {
  std::vector<Wire<Drive>> drives = ingest_drives(compile, RecordingUse::kMapping);
  compile.drive = drives.front();
  drives.erase(drives.begin());
  if (!drives.empty()) compile.drive = compile.plan.run(kJoinDrives, compile.drive, drives);
}

// Step 3: poses. From here on every scan of the first sensor has a pose in the map frame, and its
// points are as if they had been measured at once. Beside an earlier map (`base`) its drives keep
// their poses, the others are placed among them, and scans of these that show nothing new are not
// added to the map.

Wire<Drive> undistort_first_sensor(Wire<Trajectory> trajectory, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const bool is_only = recordings_for(compile, RecordingUse::kOtherSensor).empty();
  return plan.run_as(is_only ? "" : "first-sensor", kUndistortScans, plan.options(kUndistortScans),
                     compile.drive, trajectory);
}

// Beside an earlier map.
void extend_poses(CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.base = plan.input<ReleasedPoses>("base/released-poses");
  const Wire<Drive> shipped = plan.run(kReleasedDrive, compile.drive, compile.base);
  const Wire<Trajectory> kept = plan.run(kReleasedTrajectory, compile.drive, compile.base);
  // For the estimate scans are undistorted by default options, whatever the map is made of.
  const Wire<Drive> straight =
      plan.run_as("released", kUndistortScans.in(Stage::kGraph), {}, shipped, kept);
  const Wire<Trajectory> extended =
      plan.run_as("", kExtendReleased, plan.options(kEstimateTrajectory), compile.drive, straight,
                  compile.base);
  compile.of_first_sensor = undistort_first_sensor(extended, compile);
  compile.trajectory =
      plan.run(kChooseScans, compile.drive, compile.of_first_sensor, extended, compile.base);
}

void estimate_poses(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.base_file = config.base_poses;
  if (compile.base_file.empty()) {
    compile.trajectory = plan.run(kEstimateTrajectory, compile.drive);
    compile.of_first_sensor = undistort_first_sensor(compile.trajectory, compile);
  } else {
    extend_poses(compile);
  }
  compile.released = plan.run(kReleasePoses, compile.drive, compile.trajectory);
  const bool are_several = recordings_for(compile, RecordingUse::kMapping).size() > 1;
  compile.ships_poses = are_several || !compile.base_file.empty();
}

// Step 4: the map. The scans of the vehicle's other sensors join those of the first. What moved is
// removed: from here on all points that are left belong to what stood still. Of them come the NDs,
// the surface that rays hit, their sharpness, and, of several drives, which of them each tile is
// from. Sites follow the route of the first sensor.

struct MappingScans {
  Wire<Drive> drive;  // not yet undistorted
  Wire<Trajectory> trajectory;
  Wire<Drive> undistorted;
};

MappingScans scans_of_all_sensors(CompilePlan& compile) {
  Plan& plan = compile.plan;
  const std::vector<Wire<Drive>> others = ingest_drives(compile, RecordingUse::kOtherSensor);
  if (others.empty()) return {compile.drive, compile.trajectory, compile.of_first_sensor};
  const Wire<Drive> joined = plan.run(kJoinSensors, compile.drive, others);
  const Wire<Trajectory> complete = plan.run(kCompleteTrajectory, joined, compile.trajectory);
  return {joined, complete, plan.run(kUndistortScans, joined, complete)};
}

// Of a small map the NDs are chosen before anything is measured in them.
void keep_what_is_needed(CompilePlan& compile) {
  Plan& plan = compile.plan;
  const PackNdsOptions packing{plan.options(kEmitMap).size};
  if (packing.size == MapSize::kPromise) {
    compile.ndt = plan.run(kChooseNds, compile.ndt, compile.sites);
  }
  compile.packed_nds = plan.run_as("", kPackNds, packing, compile.ndt);
}

void build_map(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const MappingScans mapping = scans_of_all_sensors(compile);
  compile.undistorted = mapping.undistorted;
  RemoveMovingOptions moving = plan.options(kRemoveMoving);
  ChooseSitesOptions route = plan.options(kChooseSites);
  moving.scans = route.scans = scan_shares(config).mapping;
  compile.points = plan.run_as("", kRemoveMoving, moving, mapping.undistorted, mapping.trajectory);
  if (recordings_for(compile, RecordingUse::kMapping).size() > 1) {
    compile.tile_drives = plan.run(kCountDrives, mapping.drive, mapping.trajectory, compile.points);
  }
  compile.ndt = plan.run(kBuildNdt, compile.points);
  compile.surface = plan.run(kBuildSurface, compile.points);
  const bool is_one_sensor = mapping.drive == compile.drive;
  compile.sharpness = plan.run(
      kMeasureSharpness, is_one_sensor ? compile.undistorted : compile.drive, compile.trajectory);
  compile.sites = plan.run_as("", kChooseSites, route, compile.drive, compile.trajectory);
  keep_what_is_needed(compile);
  compile.columns.push_back(plan.run(kCountRemoved, compile.points, compile.sites));
}

// Steps 2 to 4 of a finished map: it is another source of NDs, surface and sites. All of its points
// are taken for what stood still. Sites lie along a route or everywhere on its ground.

void add_surroundings(CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  if (finished.options.is_compiled) {
    finished.compiled = plan.input<CompiledMap>("map/compiled-map");
    compile.ndt = plan.run(kIngestCompiledMap, finished.compiled);
  } else if (finished.options.is_apollo) {
    finished.nds = plan.input<ForeignNds>("map/foreign-nds");
    compile.ndt = plan.run(kIngestNdMap, finished.nds);
  } else {
    finished.points = plan.input<PointMap>("map/point-map");
    compile.points = plan.run(kIngestMap, finished.points);
    compile.ndt = plan.run(kBuildNdt, compile.points);
    compile.surface = plan.run(kBuildSurface, compile.points);
    return;
  }
  compile.surface = plan.run(kBuildNdSurface, compile.ndt);
}

void take_finished_map(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  finished.options = config.map;
  finished.route_options = config.route;
  finished.world = config.annotation.world;
  finished.sensor = plan.input<SensorProfile>("map/sensor");
  if (!compile.localizing_sensor.is_connected()) compile.localizing_sensor = finished.sensor;
  add_surroundings(compile);
  if (config.route.is_everywhere()) {
    compile.sites = plan.run(kChooseFieldSites, compile.surface, compile.localizing_sensor);
  } else {
    finished.route = plan.input<Route>("route");
    compile.sites =
        plan.run(kChooseRouteSites, finished.route, compile.surface, compile.localizing_sensor);
  }
  keep_what_is_needed(compile);
}

// Step 5: factors. From here on the map is done; what follows asks how well a vehicle localizes in
// it, by the sensor that will localize. Depth images and virtual scans of the whole map are made
// only for those who look at them: factors are computed with their own, block of sites by block.
//
// A further figure of each site, beside the factors, is one line in the step that has its inputs.
// Of NDs and sites it is a line here:
//
//   compile.columns.push_back(plan.run(kMeanNdDensity, compile.ndt, compile.sites));
//
// The map keeps the figure, and reader, differences, exports and reports show it.
Wire<FactorTable> compute_factors(CompilePlan& compile) {
  Plan& plan = compile.plan;
  const Wire<SensorProfile>& sensor = compile.localizing_sensor;
  compile.depth = plan.run(kCastRays, compile.surface, compile.sites, sensor);
  plan.run(kCastScans, compile.surface, compile.sites, sensor);
  const FactorsOfSitesOptions seeing{plan.options(kComputeFactors).ranges_m,
                                     plan.options(kCastRays), plan.options(kCastScans)};
  const Wire<FactorTable> factors =
      plan.run_as("", kComputeFactors, seeing, compile.ndt, compile.surface, compile.sites, sensor);
  compile.columns.push_back(plan.run(kNameKinds, compile.sites, factors));
  return factors;
}

// Step 6: evidence. The scans that made the map are localized in it, at the poses that they made it
// with; in a finished map simulated scans are. From here on every site has an error that needs no
// other drive. A model that learns one half of a drive from the other would trust this
// error too much elsewhere: it is evidence for the choice then, not a factor.

Wire<ByFamily<MeasuredError>> measure_own_scans(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  if (config.has_map()) {
    SimulateErrorOptions simulating = plan.options(kSimulateError);
    simulating.matching = evidence_options(config, plan);
    compile.simulated = plan.run_as("", kSimulateError, simulating, compile.surface, compile.ndt,
                                    compile.sites, compile.localizing_sensor);
    return compile.simulated;
  }
  MeasureErrorOptions options = evidence_options(config, plan);
  options.site_step = 1;
  return plan.run_as("own", kMeasureError, options, compile.of_first_sensor, compile.trajectory,
                     compile.ndt, compile.sites);
}

void add_evidence(const CompileConfig& config, Wire<FactorTable> map_factors,
                  CompilePlan& compile) {
  const Wire<ByFamily<MeasuredError>> own = measure_own_scans(config, compile);
  const bool learns_here = config.is_split() && !compile.given_model.is_connected();
  Maybe<SensorProfile> mapping_sensor;
  if (!config.has_map() && !learns_here) mapping_sensor = compile.recordings.front().sensor;
  compile.factors = compile.plan.run(kAddMappingError, map_factors, own, mapping_sensor,
                                     compile.localizing_sensor);
}

// Step 7: localization drives. Each is estimated by itself, undistorted by its own motion and only
// then aligned to the map, which is made of such scans: from here on it is expressed in the frame
// of the map. Its errors are measured, or were measured by a localizer outside. Of several drives
// `measured` takes each in turn. A finished map without any keeps its simulated errors.

LocalizedDrive add_localized(std::string_view role, CompilePlan& compile,
                             bool may_be_elsewhere = false) {
  RecordingInput& input = *std::ranges::find(compile.recordings, role, &RecordingInput::role);
  const LocalizedDrive localized =
      add_drive(compile.plan, input, compile.ndt, compile.sites, may_be_elsewhere);
  input.drive = localized.drive;
  return localized;
}

void measure_drives(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const std::vector<RecordingInput> recordings =
      recordings_for(compile, RecordingUse::kLocalization);
  compile.measured = compile.simulated;
  if (recordings.empty() && config.has_map()) return;
  compile.localized = recordings.empty() ? LocalizedDrive{compile.drive, compile.trajectory,
                                                          compile.of_first_sensor}
                                         : add_localized(recordings.front().role, compile);
  OnMap on{plan, compile.ndt, compile.sites, measuring_options(config, plan)};
  compile.measured =
      add_errors(config, RecordingUse::kLocalization, compile.localized, on, compile.outside);
  std::vector<Wire<Drive>> drives = {compile.localized.drive};
  std::vector<Wire<ByFamily<MeasuredError>>> errors = {compile.measured};
  on.measuring.may_be_elsewhere = true;
  for (std::size_t i = 1; i < recordings.size(); ++i) {
    const LocalizedDrive later =
        add_localized(recordings[i].role, compile, /*may_be_elsewhere=*/true);
    drives.push_back(later.drive);
    errors.push_back(measure(recordings[i].role, later, on));
  }
  if (drives.size() == 1) return;
  compile.measured_drives = plan.run(kJoinErrors, drives, errors);
  compile.measured = plan.run(kPoolErrors, compile.measured_drives);
}

// Whose evidence it is: from here on copies of a recording are recognized as one.
void identify(std::string_view label, CompilePlan& compile) {
  std::vector<Wire<Drive>> drives;
  for (const RecordingInput& input : compile.recordings) drives.push_back(input.drive);
  compile.identified = compile.plan.run_as(label, kIdentifyRecordings, {}, compile.cards, drives);
}

// Step 8: the model. It learns from the drives above, or is given and then predicts with what they
// measured here, and with what drives measured in a compiled map before it was annotated anew. From
// here on every site has a prediction, by trees that never saw its place.

// A model that learns here has no other drives to learn their worth from.
void add_history_of_map(CompilePlan& compile) {
  const Wire<CompiledMap>& map = compile.finished.compiled;
  if (!map.is_connected() || !compile.given_model.is_connected()) return;
  Plan& plan = compile.plan;
  const HistoryOfMapOptions options{plan.options(kMeasureError).site_radius_m};
  compile.measured_drives =
      plan.run_as("", kHistoryOfMap, options, map, compile.sites, compile.localizing_sensor,
                  compile.measured, compile.measured_drives);
}

// Whether the model is given what was measured here; what was simulated is no history.
bool has_history(const CompileConfig& config, const CompilePlan& compile) {
  const bool is_measured =
      compile.measured != compile.simulated || compile.measured_drives.is_connected();
  return compile.given_model.is_connected() && is_measured &&
         config.passes.options(kPredictError).history == HistoryUse::kAuto;
}

// The errors that are inputs of a model made elsewhere.
struct HistoryWires {
  Maybe<ByFamily<MeasuredError>> one;
  Maybe<MeasuredDrives> several;
};
HistoryWires history_wires(const CompileConfig& config, const CompilePlan& compile) {
  HistoryWires history;
  if (!has_history(config, compile)) return history;
  if (compile.measured_drives.is_connected()) {
    history.several = compile.measured_drives;
  } else {
    history.one = compile.measured;
  }
  return history;
}

void predict(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  add_history_of_map(compile);
  compile.model = compile.given_model.is_connected()
                      ? compile.given_model
                      : plan.run(kTrainModelHere, compile.sites, compile.factors, compile.measured,
                                 compile.identified, compile.measured_drives);
  const HistoryWires history = history_wires(config, compile);
  compile.predicted = plan.run(kPredictError, compile.model, compile.sites, compile.factors,
                               compile.identified, history.one, history.several);
}

// What drives measured; what was simulated is no measurement.
Maybe<ByFamily<MeasuredError>> measured_of(const CompilePlan& compile) {
  if (compile.measured == compile.simulated) return {};
  return compile.measured;
}

// Step 9: the choice. From here on every site has its range and looks, with a promise or the reason
// why there is none. What several drives measured stays beside the map's factors, so that the
// choice can be made again from the map.
void choose(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const HistoryWires history = history_wires(config, compile);
  compile.kept_factors = compile.factors;
  if (has_history(config, compile)) {
    if (!compile.measured_drives.is_connected()) {
      compile.measured_drives = plan.run(kJoinErrors, std::vector{compile.localized.drive},
                                         std::vector{compile.measured});
    }
    compile.kept_factors = plan.run(kAddHistory, compile.factors, compile.measured_drives,
                                    compile.predicted, compile.model, compile.identified);
  }
  compile.ranges = plan.run(kChooseRanges, compile.sites, compile.predicted, compile.model,
                            compile.kept_factors, measured_of(compile));
  const ChooseTrackingLooksOptions tracking{plan.options(kChooseRanges),
                                            plan.options(kPredictError).support_margin};
  compile.tracking_looks =
      plan.run_as("", kChooseTrackingLooks, tracking, compile.sites, compile.model, compile.factors,
                  compile.identified, measured_of(compile), history.one, history.several);
  compile.evaluation = plan.run(kEvaluateRanges, compile.sites, compile.predicted, compile.ranges,
                                compile.factors, compile.measured);
}

// Step 10: the file. The model is packed first: from here on it is not needed whole. On the drive
// that was localized the plan of a vehicle that tracks is calibrated; a finished map has none.
void write_map(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  const Wire<PackedModel> packed_model = plan.run(kPackModel, compile.model);
  EmitMapOptions emitting = plan.options(kEmitMap);
  emitting.mapping_scans = scan_shares(config).mapping;
  if (!config.has_map()) {
    CalibratePlanOptions tracking = plan.options(kCalibratePlan);
    tracking.matching = measuring_options(config, plan);
    tracking.reach_m = emitting.reach_m;
    compile.look_plan =
        plan.run_as("", kCalibratePlan, tracking, compile.localized.undistorted,
                    compile.localized.trajectory, compile.ndt, compile.sites, compile.ranges);
  }
  compile.map = plan.run_as("", kEmitMap, emitting, compile.packed_nds, compile.sites,
                            compile.predicted, compile.ranges, compile.measured, packed_model,
                            compile.kept_factors, compile.localizing_sensor, compile.identified,
                            compile.drive, compile.trajectory, compile.sharpness, compile.look_plan,
                            compile.tile_drives, compile.finished.compiled, compile.finished.nds,
                            compile.tracking_looks, compile.columns);
}

}  // namespace

CompilePlan compile_plan(const CompileConfig& config, ModelSource model) {
  CompilePlan compile = with_inputs(config, model);
  if (config.has_map()) {
    take_finished_map(config, compile);
  } else {
    read_drives(compile);
    estimate_poses(config, compile);
    build_map(config, compile);
  }
  const Wire<FactorTable> map_factors = compute_factors(compile);
  add_evidence(config, map_factors, compile);
  measure_drives(config, compile);
  identify("", compile);
  predict(config, compile);
  choose(config, compile);
  write_map(config, compile);
  return compile;
}

std::vector<AnyWire> reported_artifacts(const CompilePlan& compile) {
  std::vector<AnyWire> reported = {compile.map,    compile.sites,   compile.measured,
                                   compile.ranges, compile.factors, compile.evaluation};
  if (compile.sharpness.is_connected()) reported.push_back(compile.sharpness);
  if (compile.ships_poses) reported.push_back(compile.released);
  return reported;
}

Wire<ByFamily<MeasuredError>> measure_evaluation_drive(const CompileConfig& config,
                                                       CompilePlan& compile) {
  Plan& plan = compile.plan;
  const RecordingUse use = RecordingUse::kEvaluation;
  compile.recordings.push_back(add_recording(plan, {use}, config.evaluation));
  const LocalizedDrive drive = add_localized(compile.recordings.back().role, compile);
  identify(compile.recordings.back().role, compile);
  return add_errors(config, use, drive,
                    {plan, compile.ndt, compile.sites, measuring_options(config, plan)},
                    compile.outside);
}

}  // namespace sightline
