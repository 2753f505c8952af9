#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "compiler/driver/config_file.h"
#include "formats/default_ranges.h"
#include "formats/foreign/recording.h"
#include "passes/align_drive.h"
#include "passes/build_ndt.h"
#include "passes/build_surface.h"
#include "passes/cast_rays.h"
#include "passes/cast_scans.h"
#include "passes/choose_ranges.h"
#include "passes/choose_sites.h"
#include "passes/compute_factors.h"
#include "passes/emit_map.h"
#include "passes/estimate_trajectory.h"
#include "passes/evaluate_ranges.h"
#include "passes/ingest.h"
#include "passes/measure_error.h"
#include "passes/measure_sharpness.h"
#include "passes/predict_error.h"
#include "passes/remove_moving.h"
#include "passes/track_drive.h"
#include "passes/train_model.h"
#include "passes/undistort_scans.h"

namespace sightline {

// What several passes must agree on; each of them takes it from here.
struct AnnotationOptions {
  std::vector<double> ranges_m = default_ranges_m();
  std::vector<double> limits_m = {0.10, 0.25};
  double leaf_m = 1.0;
  double tile_m = 64.0;
  int seed = 1;
  // even-odd: one recording is both drives; even scans map, odd scans localize. auto: even-odd
  // where no localization drive is named.
  std::string split = "auto";
};
std::vector<OptionField> option_fields(AnnotationOptions& options);

// One YAML file: everything a compile and its evaluation depend on.
struct CompileConfig {
  AnnotationOptions annotation;
  RecordingOptions mapping;
  // What else on the vehicle scanned during the mapping drive; no scans: there is none.
  std::array<RecordingOptions, 3> other_sensors;
  RecordingOptions localization;  // no scans: see AnnotationOptions::split
  RecordingOptions evaluation;    // an independent drive, for `evaluate`
  IngestOptions ingest;
  EstimateTrajectoryOptions estimate_trajectory;
  AlignDriveOptions align_drive;
  MeasureSharpnessOptions measure_sharpness;
  UndistortScansOptions undistort_scans;
  RemoveMovingOptions remove_moving;
  BuildNdtOptions build_ndt;
  BuildSurfaceOptions build_surface;
  ChooseSitesOptions choose_sites;
  CastRaysOptions cast_rays;
  CastScansOptions cast_scans;
  ComputeFactorsOptions compute_factors;
  MeasureErrorOptions measure_error;
  TrainModelOptions train_model;
  PredictErrorOptions predict_error;
  ChooseRangesOptions choose_ranges;
  EvaluateRangesOptions evaluate_ranges;
  TrackDriveOptions track_drive;
  EmitMapOptions emit_map;

  [[nodiscard]] bool is_split() const { return localization.scans.empty(); }
};

// "mapping-2" of the first of other_sensors, and so on.
std::string other_sensor_section(std::size_t index);

// Sections in the order of the file. Fields that AnnotationOptions sets for all passes are left out
// of the sections of passes.
std::vector<ConfigSection> sections(CompileConfig& config);

// Reads the file, then the overrides ("section.key=value"); paths become relative to the file's
// folder; what passes share is spread to them. Errors: those of read_yaml and set_override,
// missing-key (no mapping drive), bad-value (a split beside a localization drive).
Result<CompileConfig> load_compile_config(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides);

}  // namespace sightline
