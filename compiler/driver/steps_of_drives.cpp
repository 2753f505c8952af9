#include "compiler/driver/steps_of_drives.h"

#include "passes/ingest/ingest.h"
#include "passes/localize/add_mapping_error.h"
#include "passes/localize/import_errors.h"
#include "passes/localize/join_errors.h"
#include "passes/localize/site_localizer.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/undistort_scans.h"

namespace sightline {

ScanShares scan_shares(const CompileConfig& config) {
  return config.is_split() ? ScanShares{ScanSelection::kEven, ScanSelection::kOdd} : ScanShares{};
}

MeasureErrorOptions measuring_options(const CompileConfig& config, const Plan& plan) {
  MeasureErrorOptions options = plan.options(kMeasureError);
  const bool is_own = options.localizer != LocalizerKind::kPclNdt && !config.imports_errors();
  if (!is_own) options.looks.clear();
  return options;
}

RecordingInput add_recording(Plan& plan, const std::string& role, const RecordingOptions& options) {
  return {role, options, plan.input<Recording>(role + "/recording"),
          plan.input<SensorProfile>(role + "/sensor")};
}

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

LocalizedDrive add_drive(Plan& plan, const RecordingInput& input, Wire<NdtMap> ndt,
                         Wire<Sites> sites, bool may_be_elsewhere) {
  const std::string& role = input.role;
  // What a second drive knows of itself, however the first one's poses came about.
  EstimateTrajectoryOptions own_poses = plan.options(kEstimateTrajectory);
  own_poses.mode = EstimateTrajectoryOptions{}.mode;
  LocalizedDrive localized;
  localized.drive = plan.run_as(role, kIngest, plan.options(kIngest), input.recording);
  // Each by itself: no other drive is needed for it.
  const Wire<Trajectory> own =
      plan.run_as(role, kEstimateTrajectory.in(Stage::kDrives), own_poses, localized.drive);
  // By the drive's own motion, and before it is laid into the map, which is made of such scans: one
  // that is drawn out lies best on it where it has not been.
  localized.undistorted =
      plan.run_as(role, kUndistortScans, plan.options(kUndistortScans), localized.drive, own);
  // From here on the drive is expressed in the frame of the map.
  AlignDriveOptions aligning = plan.options(kAlignDrive);
  aligning.may_be_elsewhere = may_be_elsewhere;
  localized.trajectory =
      plan.run_as(role, kAlignDrive, aligning, localized.undistorted, own, ndt, sites);
  return localized;
}

void add_localization_errors(const CompileConfig& config, const LocalizedDrive& first,
                             const OnMap& on, CompilePlan& compile) {
  Plan& plan = on.plan;
  compile.measured = add_errors(config, "", first, on, compile.outside);
  MeasureErrorOptions measuring = on.measuring;
  measuring.may_be_elsewhere = true;
  std::vector<Wire<Drive>> drives = {first.drive};
  std::vector<Wire<MeasuredError>> errors = {compile.measured};
  for (std::size_t i = 0; i < config.later_localization.size(); ++i) {
    const std::string role = later_localization_role(i);
    compile.recordings.push_back(add_recording(plan, role, config.later_localization[i]));
    const LocalizedDrive later =
        add_drive(plan, compile.recordings.back(), on.ndt, on.sites, /*may_be_elsewhere=*/true);
    drives.push_back(later.drive);
    errors.push_back(plan.run_as(role, kMeasureError, measuring, later.undistorted,
                                 later.trajectory, on.ndt, on.sites));
  }
  if (drives.size() == 1) return;
  compile.measured_drives = plan.run(kJoinErrors, drives, errors);
  compile.measured = plan.run(kPoolErrors, compile.measured_drives);
}

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
  const Wire<MeasuredError> own = plan.run_as("own", kMeasureError, options, mapping.undistorted,
                                              mapping.trajectory, compile.ndt, compile.sites);
  // A model that learnt one half of a drive from the other would believe it too much elsewhere.
  Maybe<SensorProfile> mapping_sensor;
  if (!learns_here) mapping_sensor = compile.recordings.front().sensor;
  return plan.run(kAddMappingError, map_factors, own, mapping_sensor, localizing_sensor);
}

}  // namespace sightline
