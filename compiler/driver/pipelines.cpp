#include "compiler/driver/pipelines.h"

#include <algorithm>
#include <utility>

#include "compiler/base/atomic_file.h"
#include "formats/foreign/open_recording.h"
#include "formats/map/map_reader.h"
#include "passes/add_mapping_error.h"
#include "passes/complete_trajectory.h"
#include "passes/join_sensors.h"

namespace sightline {
namespace {

// What a second drive knows of itself, however the first one's poses came about.
EstimateTrajectoryOptions own_poses(EstimateTrajectoryOptions options) {
  options.mode = "auto";
  return options;
}

// The scans that made a map, localized in it: they have the poses that they made it with.
MeasureErrorOptions of_mapping_scans(const CompileConfig& config) {
  MeasureErrorOptions options = config.measure_error;
  options.scans = config.remove_moving.scans;
  options.reference = "known";
  return options;
}

// The next two passes take their many inputs as one struct; the runner reads them off these
// signatures.
Result<ErrorModel> train_model_step(PassContext& ctx, const TrainModelOptions& options,
                                    const Sites& sites, const FactorTable& factors,
                                    const MeasuredError& measured,
                                    const RecordingCards& recordings) {
  return train_model_here(ctx, options, {measured.drive, sites, factors, {measured}, recordings});
}

Result<CompiledMap> emit_map_step(PassContext& ctx, const EmitMapOptions& options,
                                  const Drive& mapping, const Drive& localization,
                                  const NdtMap& ndt, const Sites& sites,
                                  const PredictedError& predicted, const RangeTable& ranges,
                                  const MeasuredError& measured, const ErrorModel& model,
                                  const FactorTable& factors, const Sharpness& sharpness,
                                  const Trajectory& trajectory) {
  return emit_map(ctx, options,
                  {mapping, localization, ndt, sites, predicted, ranges, measured, model, factors,
                   &sharpness, &trajectory});
}

Result<void> provide_drive(const std::string& name, const RecordingOptions& options,
                           ArtifactSet& artifacts) {
  Result<Recording> recording = open_recording(options, /*threads=*/0);
  if (!recording) return recording.error();
  const Digest digest = recording->digest;
  artifacts.provide(name + "/sensor", recording->sensor, sha256(to_bytes(recording->sensor)));
  artifacts.provide(name + "/recording", std::move(*recording), digest);
  return {};
}

void provide_recording_cards(const CompileConfig& config, ArtifactSet& artifacts) {
  RecordingCards recordings = recording_cards(config, artifacts);
  const Digest digest = sha256(to_bytes(recordings));
  artifacts.provide("recording-cards", std::move(recordings), digest);
}

// What a drive and its trajectory are called.
struct DriveNames {
  std::string drive;
  std::string trajectory;
};

// Joins the scans of the vehicle's other sensors to those of the first, one sensor after the other.
DriveNames add_other_sensors(const CompileConfig& c, std::vector<PassStep>& steps) {
  DriveNames joined{"mapping/drive", "mapping/trajectory"};
  for (std::size_t i = 0; i < c.other_sensors.size(); ++i) {
    if (c.other_sensors[i].scans.empty()) continue;
    const std::string sensor = other_sensor_section(i);
    steps.push_back(make_step("ingest:" + sensor, kIngestVersion, &ingest, c.ingest,
                              {sensor + "/recording"}, sensor + "/drive"));
    const std::string drive = "mapping/joined-with-" + sensor;
    steps.push_back(make_step("join-sensors:" + sensor, kJoinSensorsVersion, &join_sensors,
                              JoinSensorsOptions{}, {joined.drive, sensor + "/drive"}, drive));
    joined.drive = drive;
  }
  if (joined.drive == "mapping/drive") return joined;
  joined.trajectory = "mapping/joined-trajectory";
  steps.push_back(make_step("complete-trajectory", kCompleteTrajectoryVersion, &complete_trajectory,
                            CompleteTrajectoryOptions{}, {joined.drive, "mapping/trajectory"},
                            joined.trajectory));
  return joined;
}

}  // namespace

std::vector<PassStep> compile_pipeline(const CompileConfig& c, ModelSource model) {
  std::vector<PassStep> steps;
  const auto add = [&](PassStep step) { steps.push_back(std::move(step)); };

  add(make_step("ingest", kIngestVersion, &ingest, c.ingest, {"mapping/recording"},
                "mapping/drive"));
  // From here on points are finite, times rise, and a frame near the drive is chosen.
  add(make_step("estimate-trajectory", kEstimateTrajectoryVersion, &estimate_trajectory,
                c.estimate_trajectory, {"mapping/drive"}, "mapping/trajectory"));
  const DriveNames mapping = add_other_sensors(c, steps);
  // From here on every mapping scan, of any sensor, has a pose in the map frame.
  add(make_step("undistort-scans", kUndistortScansVersion, &undistort_scans, c.undistort_scans,
                {mapping.drive, mapping.trajectory}, "mapping/undistorted"));
  // From here on a scan is as if it had been measured at once.
  add(make_step("remove-moving", kRemoveMovingVersion, &remove_moving, c.remove_moving,
                {"mapping/undistorted", mapping.trajectory}, "surface-points"));
  // From here on all that is left stood still.
  add(make_step("build-ndt", kBuildNdtVersion, &build_ndt, c.build_ndt, {"surface-points"},
                "ndt-map"));
  add(make_step("build-surface", kBuildSurfaceVersion, &build_surface, c.build_surface,
                {"surface-points"}, "surface"));
  add(make_step("measure-sharpness", kMeasureSharpnessVersion, &measure_sharpness,
                c.measure_sharpness, {"mapping/drive", "mapping/trajectory"}, "sharpness"));
  add(make_step("choose-sites", kChooseSitesVersion, &choose_sites, c.choose_sites,
                {"mapping/drive", "mapping/trajectory"}, "sites"));
  add(make_step("cast-rays", kCastRaysVersion, &cast_rays, c.cast_rays, {"surface", "sites"},
                "depth-images"));
  add(make_step("cast-scans", kCastScansVersion, &cast_scans, c.cast_scans,
                {"surface", "sites", "localization/sensor"}, "virtual-scans"));
  add(make_step("compute-factors", kComputeFactorsVersion, &compute_factors, c.compute_factors,
                {"ndt-map", "sites", "depth-images", "virtual-scans"}, "map-factors"));
  // From here on the map is done; what follows asks how well a vehicle localizes in it, by its
  // first sensor.
  std::string drive = "mapping/drive";
  std::string trajectory = "mapping/trajectory";
  std::string undistorted = "mapping/undistorted";
  if (mapping.drive != drive) {
    undistorted = "mapping/first-undistorted";
    add(make_step("undistort-scans:first", kUndistortScansVersion, &undistort_scans,
                  c.undistort_scans, {drive, trajectory}, undistorted));
  }
  if (c.is_split() && model == ModelSource::kTrained) {
    // A model that learnt one half of a drive from the other would believe it too much elsewhere.
    add(make_step("add-mapping-error", kAddMappingErrorVersion, &add_no_mapping_error,
                  AddMappingErrorOptions{}, {"map-factors"}, "factor-table"));
  } else {
    add(make_step("measure-error:mapping", kMeasureErrorVersion, &measure_error,
                  of_mapping_scans(c), {undistorted, trajectory, "ndt-map", "sites"},
                  "mapping/measured-error"));
    add(make_step("add-mapping-error", kAddMappingErrorVersion, &add_mapping_error,
                  AddMappingErrorOptions{},
                  {"map-factors", "mapping/measured-error", "mapping/sensor",
                   "localization/sensor"},
                  "factor-table"));
  }
  if (!c.is_split()) {
    drive = "localization/drive";
    trajectory = "localization/trajectory";
    undistorted = "localization/undistorted";
    add(make_step("ingest:localization", kIngestVersion, &ingest, c.ingest,
                  {"localization/recording"}, drive));
    add(make_step("estimate-trajectory:localization", kEstimateTrajectoryVersion,
                  &estimate_trajectory, own_poses(c.estimate_trajectory), {drive},
                  "localization/own-trajectory"));
    add(make_step("align-drive", kAlignDriveVersion, &align_drive, c.align_drive,
                  {drive, "localization/own-trajectory", "ndt-map", "sites"}, trajectory));
    // From here on both drives are told in the same frame.
    add(make_step("undistort-scans:localization", kUndistortScansVersion, &undistort_scans,
                  c.undistort_scans, {drive, trajectory}, undistorted));
  }
  add(make_step("measure-error", kMeasureErrorVersion, &measure_error, c.measure_error,
                {undistorted, trajectory, "ndt-map", "sites"}, "measured-error"));
  if (model == ModelSource::kTrained) {
    add(make_step("train-model", kTrainModelVersion, &train_model_step, c.train_model,
                  {"sites", "factor-table", "measured-error", "recording-cards"}, "error-model"));
  }
  if (model == ModelSource::kGiven && c.predict_error.history == "auto") {
    add(make_step("predict-error", kPredictErrorVersion, &predict_error_with_history,
                  c.predict_error, {"error-model", "sites", "factor-table", "measured-error"},
                  "predicted-error"));
  } else {
    add(make_step("predict-error", kPredictErrorVersion, &predict_error, c.predict_error,
                  {"error-model", "sites", "factor-table"}, "predicted-error"));
  }
  // From here on every site's prediction comes from trees that never saw its place.
  add(make_step("choose-ranges", kChooseRangesVersion, &choose_ranges, c.choose_ranges,
                {"sites", "predicted-error", "error-model"}, "range-table"));
  add(make_step("evaluate-ranges", kEvaluateRangesVersion, &evaluate_ranges, c.evaluate_ranges,
                {"sites", "predicted-error", "range-table", "factor-table", "measured-error"},
                "evaluation"));
  add(make_step("emit-map", kEmitMapVersion, &emit_map_step, c.emit_map,
                {"mapping/drive", drive, "ndt-map", "sites", "predicted-error", "range-table",
                 "measured-error", "error-model", "factor-table", "sharpness",
                 "mapping/trajectory"},
                "compiled-map"));
  return steps;
}

std::vector<PassStep> evaluate_pipeline(const CompileConfig& c) {
  std::vector<PassStep> steps;
  steps.push_back(make_step("ingest:evaluation", kIngestVersion, &ingest, c.ingest,
                            {"evaluation/recording"}, "evaluation/drive"));
  steps.push_back(make_step("estimate-trajectory:evaluation", kEstimateTrajectoryVersion,
                            &estimate_trajectory, own_poses(c.estimate_trajectory),
                            {"evaluation/drive"}, "evaluation/own-trajectory"));
  steps.push_back(make_step(
      "align-drive:evaluation", kAlignDriveVersion, &align_drive, c.align_drive,
      {"evaluation/drive", "evaluation/own-trajectory", "ndt-map", "sites"},
      "evaluation/trajectory"));
  steps.push_back(make_step("undistort-scans:evaluation", kUndistortScansVersion, &undistort_scans,
                            c.undistort_scans, {"evaluation/drive", "evaluation/trajectory"},
                            "evaluation/undistorted"));
  steps.push_back(make_step(
      "measure-error:evaluation", kMeasureErrorVersion, &measure_error, c.measure_error,
      {"evaluation/undistorted", "evaluation/trajectory", "ndt-map", "sites"}, "measured-error"));
  steps.push_back(
      make_step("evaluate-ranges", kEvaluateRangesVersion, &evaluate_ranges, c.evaluate_ranges,
                {"sites", "predicted-error", "range-table", "factor-table", "measured-error"},
                "evaluation"));
  TrackDriveOptions tracking = c.track_drive;
  tracking.matching = c.measure_error;
  steps.push_back(make_step(
      "track-drive", kTrackDriveVersion, &track_drive, tracking,
      {"evaluation/undistorted", "evaluation/trajectory", "ndt-map", "sites", "range-table"},
      "drive-tracks"));
  return steps;
}

std::vector<PassStep> measure_pipeline(const CompileConfig& c, bool also_evaluation) {
  std::vector<PassStep> steps = compile_pipeline(c, ModelSource::kTrained);
  const auto is_last = [](const PassStep& step) { return step.name == "measure-error"; };
  steps.erase(std::ranges::find_if(steps, is_last) + 1, steps.end());
  if (!also_evaluation) return steps;
  for (PassStep& step : evaluate_pipeline(c)) {
    if (step.output == "evaluation") break;
    if (step.output == "measured-error") step.output = "evaluation/measured-error";
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<PassStep> train_pipeline(const TrainModelOptions& options) {
  return {make_step("train-model", kTrainModelVersion, &train_model, options, {"driven-places"},
                    "error-model")};
}

Result<void> provide_drives(const CompileConfig& config, ArtifactSet& artifacts) {
  const Result<void> mapping = provide_drive("mapping", config.mapping, artifacts);
  if (!mapping) return mapping;
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    if (config.other_sensors[i].scans.empty()) continue;
    const Result<void> other =
        provide_drive(other_sensor_section(i), config.other_sensors[i], artifacts);
    if (!other) return other;
  }
  Result<void> localization;
  if (config.is_split()) {
    // One recording is both: what localizes is the mapping drive's own sensor.
    artifacts.put("localization/sensor", artifacts.entry("mapping/sensor"));
  } else {
    localization = provide_drive("localization", config.localization, artifacts);
  }
  if (localization) provide_recording_cards(config, artifacts);
  return localization;
}

RecordingCards recording_cards(const CompileConfig& config, const ArtifactSet& artifacts) {
  std::vector<std::string> roles = {"mapping"};
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    roles.push_back(other_sensor_section(i));
  }
  roles.insert(roles.end(), {"localization", "evaluation"});
  RecordingCards recordings;
  for (const std::string& role : roles) {
    if (!artifacts.has(role + "/recording")) continue;
    const auto& recording = artifacts.get<Recording>(role + "/recording");
    recordings.cards.push_back({role, recording.name, recording.digest});
  }
  return recordings;
}

Result<ErrorModel> read_model(const std::filesystem::path& file) {
  Result<ErrorModel> model = Error{ErrorCode::kCannotRead, "no model", file.string(), ""};
  if (file.extension() == ".slmap") {
    const Result<CompiledMap> map = read_map(file);
    if (!map) return map.error();
    model = model_of(map->model);
  } else {
    const Result<std::vector<std::byte>> bytes = read_file(file);
    if (!bytes) return bytes.error();
    model = from_bytes<ErrorModel>(*bytes);
  }
  if (!model) return in_file(model.error(), file.string());
  return model;
}

Result<void> provide_model(const std::filesystem::path& file, ArtifactSet& artifacts) {
  Result<ErrorModel> model = read_model(file);
  if (!model) return model.error();
  const Digest digest = sha256(to_bytes(*model));
  artifacts.provide("error-model", std::move(*model), digest);
  return {};
}

Result<void> provide_evaluation(const CompileConfig& config, ArtifactSet& artifacts) {
  return provide_drive("evaluation", config.evaluation, artifacts);
}

}  // namespace sightline
