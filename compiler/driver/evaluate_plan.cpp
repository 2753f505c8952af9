#include "compiler/driver/evaluate_plan.h"

#include <algorithm>

#include "formats/foreign/recording/same_recording.h"
#include "passes/ingest/identify_recordings.h"
#include "passes/ingest/ingest.h"
#include "passes/localize/import_errors.h"
#include "passes/localize/track_drive.h"
#include "passes/model/judge/evaluate_ranges.h"
#include "passes/trajectory/align_drive.h"
#include "passes/trajectory/estimate_trajectory.h"
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

bool is_of_even_scans(const CompiledMap& map) {
  return map.measurement.mapping_scans == name_of(ScanSelection::kEven);
}

// Whether the drive made the map by its even scans.
bool judges_other_scans(const CompiledMap& map, const CompileConfig& config) {
  return is_of_even_scans(map) && config.is_split() &&
         is_same_recording(config.evaluation, config.mapping);
}

// As the map was measured. A drive that also made the map is measured by its other scans.
MeasureErrorOptions measuring_as(const CompiledMap& map, const CompileConfig& config,
                                 const Plan& plan) {
  MeasureErrorOptions measuring = plan.options(kMeasureError);
  measuring.ranges_m = ranges_of(map.predicted.looks);
  measuring.every_return = took_every_return(map.model.localizer);
  measuring.in_small_map = map.size == MapSize::kPromise;
  measuring.looks.clear();
  if (map.looks) measuring.looks = with_baselines(map.looks->ranges.looks);
  measuring.scans = judges_other_scans(map, config) ? ScanSelection::kOdd : ScanSelection::kAll;
  return measuring;
}

}  // namespace

RecordingInput add_recording(Plan& plan, const RecordingRole& role,
                             const RecordingOptions& options) {
  const std::string name = to_text(role);
  return {role.use,
          name,
          options,
          plan.input<Recording>(name + "/recording"),
          plan.input<SensorProfile>(name + "/sensor"),
          {}};
}

Wire<Drive> ingest_drive(Plan& plan, const RecordingInput& input) {
  const std::string label = input.role == "mapping" ? "" : input.role;
  return plan.run_as(label, kIngest, plan.options(kIngest), input.recording);
}

LocalizedDrive add_drive(Plan& plan, const RecordingInput& input, Wire<NdtMap> ndt,
                         Wire<Sites> sites, bool may_be_elsewhere) {
  const std::string& label = input.role;
  // Its own poses, by default: options of the mode are about the first drive's poses.
  EstimateTrajectoryOptions own_poses = plan.options(kEstimateTrajectory);
  own_poses.mode = EstimateTrajectoryOptions{}.mode;
  LocalizedDrive localized;
  localized.drive = ingest_drive(plan, input);
  const Wire<Trajectory> own =
      plan.run_as(label, kEstimateTrajectory.in(Stage::kDrives), own_poses, localized.drive);
  localized.undistorted =
      plan.run_as(label, kUndistortScans, plan.options(kUndistortScans), localized.drive, own);
  AlignDriveOptions aligning = plan.options(kAlignDrive);
  aligning.may_be_elsewhere = may_be_elsewhere;
  aligning.subtracts_offset = input.options.align;
  localized.trajectory =
      plan.run_as(label, kAlignDrive, aligning, localized.undistorted, own, ndt, sites);
  return localized;
}

Wire<ByFamily<MeasuredError>> measure(std::string_view label, const LocalizedDrive& drive,
                                      const OnMap& on) {
  return on.plan.run_as(label, kMeasureError, on.measuring, drive.undistorted, drive.trajectory,
                        on.ndt, on.sites);
}

Wire<ByFamily<MeasuredError>> add_errors(const CompileConfig& config, RecordingUse use,
                                         const LocalizedDrive& drive, const OnMap& on,
                                         std::vector<OutsideInput>& outside) {
  const bool is_evaluation = use == RecordingUse::kEvaluation;
  const std::string label = is_evaluation ? "evaluation" : "";
  const std::string& file = is_evaluation ? config.outside.evaluation_file : config.outside.file;
  if (file.empty()) return measure(label, drive, on);
  const Wire<OutsideErrors> errors =
      on.plan.input<OutsideErrors>(to_text(RecordingRole{use}) + "/outside-errors");
  outside.push_back({file, config.outside, errors});
  const ImportErrorsOptions importing{on.measuring.ranges_m, on.measuring.scans,
                                      on.measuring.site_radius_m};
  return on.plan.run_as(label, kImportErrors, importing, errors, drive.drive, drive.trajectory,
                        on.sites);
}

bool has_other_scans(const CompiledMap& map, const CompileConfig& config) {
  return is_of_even_scans(map) && !map.tile_drives && config.is_split();
}

EvaluatePlan evaluate_plan(const CompileConfig& config, const CompiledMap& map) {
  EvaluatePlan evaluate;
  evaluate.plan = Plan(config.passes);
  Plan& plan = evaluate.plan;
  evaluate.ndt = plan.input<NdtMap>("map/nds");
  evaluate.sites = plan.input<Sites>("map/sites");
  evaluate.predicted = plan.input<ByFamily<PredictedError>>("map/predicted");
  evaluate.ranges = plan.input<ByFamily<RangeTable>>("map/ranges");
  evaluate.factors = plan.input<ByFamily<FactorTable>>("map/factors");
  const RecordingUse use = RecordingUse::kEvaluation;
  evaluate.recording = add_recording(plan, {use}, config.evaluation);
  const LocalizedDrive drive = add_drive(plan, evaluate.recording, evaluate.ndt, evaluate.sites);
  evaluate.judges_other_scans = judges_other_scans(map, config);
  evaluate.cards = plan.input<RecordingCards>("recordings");
  evaluate.identified = plan.run(kIdentifyRecordings, evaluate.cards, {drive.drive});
  const MeasureErrorOptions measuring = measuring_as(map, config, plan);
  evaluate.measured = add_errors(config, use, drive,
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

}  // namespace sightline
