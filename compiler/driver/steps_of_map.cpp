#include "compiler/driver/steps_of_map.h"

#include <algorithm>

#include "compiler/driver/steps_of_drives.h"
#include "passes/emit/pack_nds.h"
#include "passes/factors/factors_of_sites.h"
#include "passes/ingest/ingest.h"
#include "passes/ingest/ingest_compiled_map.h"
#include "passes/ingest/ingest_map.h"
#include "passes/ingest/ingest_nd_map.h"
#include "passes/ingest/join_drives.h"
#include "passes/ingest/join_sensors.h"
#include "passes/localize/add_mapping_error.h"
#include "passes/localize/simulate_error.h"
#include "passes/localize/site_localizer.h"
#include "passes/map/build_nd_surface.h"
#include "passes/map/build_ndt.h"
#include "passes/map/build_surface.h"
#include "passes/map/changes/choose_scans.h"
#include "passes/map/choose_sites.h"
#include "passes/map/count_drives.h"
#include "passes/map/places/choose_field_sites.h"
#include "passes/map/places/choose_route_sites.h"
#include "passes/map/remove_moving.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "passes/trajectory/complete_trajectory.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/released/extend_released.h"
#include "passes/trajectory/undistort_scans.h"

namespace sightline {
namespace {

// The map's factors, and what sites see of it, for those who look at that.
Wire<FactorTable> add_factors(Wire<SensorProfile> localizing_sensor, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.depth = plan.run(kCastRays, compile.surface, compile.sites, localizing_sensor);
  plan.run(kCastScans, compile.surface, compile.sites, localizing_sensor);
  const FactorsOfSitesOptions seeing{plan.options(kComputeFactors).ranges_m,
                                     plan.options(kCastRays), plan.options(kCastScans)};
  return plan.run_as("", kComputeFactors, seeing, compile.ndt, compile.surface, compile.sites,
                     localizing_sensor);
}

// NDs and surface of a finished map.
void add_surroundings(CompilePlan& compile) {
  Plan& plan = compile.plan;
  FinishedMapInput& finished = compile.finished;
  if (finished.options.is_compiled) {
    finished.compiled = plan.input<CompiledMap>("map/compiled-map");
    compile.ndt = plan.run(kIngestCompiledMap, finished.compiled);
    compile.surface = plan.run(kBuildNdSurface, compile.ndt);
    return;
  }
  if (finished.options.is_apollo) {
    finished.nds = plan.input<ForeignNds>("map/foreign-nds");
    compile.ndt = plan.run(kIngestNdMap, finished.nds);
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

// `trajectory`: of the first sensor's scans.
Wire<Drive> undistort_first_sensor(const CompileConfig& config, Wire<Trajectory> trajectory,
                                   CompilePlan& compile) {
  Plan& plan = compile.plan;
  const bool is_only = std::ranges::all_of(
      config.other_sensors, [](const RecordingOptions& other) { return other.scans.empty(); });
  return plan.run_as(is_only ? "" : "first-sensor", kUndistortScans, plan.options(kUndistortScans),
                     compile.drive, trajectory);
}

}  // namespace

MappingDrive with_other_sensors(const CompileConfig& config, const MappingDrive& first,
                                CompilePlan& compile) {
  Plan& plan = compile.plan;
  std::vector<Wire<Drive>> others;
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    if (config.other_sensors[i].scans.empty()) continue;
    const std::string role = other_sensor_section(i);
    compile.recordings.push_back(add_recording(plan, role, config.other_sensors[i]));
    const Wire<Drive> other =
        plan.run_as(role, kIngest, plan.options(kIngest), compile.recordings.back().recording);
    others.push_back(other);
  }
  if (others.empty()) return first;
  const Wire<Drive> joined = plan.run(kJoinSensors, first.drive, others);
  return {joined, plan.run(kCompleteTrajectory, joined, first.trajectory)};
}

Wire<Drive> with_later_drives(const CompileConfig& config, Wire<Drive> drive,
                              CompilePlan& compile) {
  Plan& plan = compile.plan;
  std::vector<Wire<Drive>> later;
  for (std::size_t i = 0; i < config.later_mapping.size(); ++i) {
    const std::string role = later_mapping_role(i);
    compile.recordings.push_back(add_recording(plan, role, config.later_mapping[i]));
    later.push_back(
        plan.run_as(role, kIngest, plan.options(kIngest), compile.recordings.back().recording));
  }
  return later.empty() ? drive : plan.run(kJoinDrives, drive, later);
}

void add_trajectory(const CompileConfig& config, CompilePlan& compile) {
  Plan& plan = compile.plan;
  compile.base_file = config.base_poses;
  if (compile.base_file.empty()) {
    compile.trajectory = plan.run(kEstimateTrajectory, compile.drive);
    compile.of_first_sensor = undistort_first_sensor(config, compile.trajectory, compile);
  } else {
    compile.base = plan.input<ReleasedPoses>("base/released-poses");
    const Wire<Drive> shipped = plan.run(kReleasedDrive, compile.drive, compile.base);
    const Wire<Trajectory> stays = plan.run(kReleasedTrajectory, compile.drive, compile.base);
    // For the estimate scans are undistorted whatever the map is made of.
    const Wire<Drive> straight =
        plan.run_as("released", kUndistortScans.in(Stage::kGraph), {}, shipped, stays);
    const Wire<Trajectory> extended =
        plan.run_as("", kExtendReleased, plan.options(kEstimateTrajectory), compile.drive, straight,
                    compile.base);
    compile.of_first_sensor = undistort_first_sensor(config, extended, compile);
    compile.trajectory =
        plan.run(kChooseScans, compile.drive, compile.of_first_sensor, extended, compile.base);
    // From here on scans of later drives that show nothing new are not laid into the map.
  }
  compile.released = plan.run(kReleasePoses, compile.drive, compile.trajectory);
  compile.ships_poses = !config.later_mapping.empty() || !compile.base_file.empty();
}

Wire<FactorTable> add_map(const CompileConfig& config, const MappingDrive& mapping,
                          Wire<SensorProfile> localizing_sensor, CompilePlan& compile) {
  Plan& plan = compile.plan;
  RemoveMovingOptions moving = plan.options(kRemoveMoving);
  ChooseSitesOptions route = plan.options(kChooseSites);
  moving.scans = route.scans = scan_shares(config).mapping;
  const bool is_one_sensor = mapping.drive == compile.drive;
  compile.undistorted = is_one_sensor
                            ? compile.of_first_sensor
                            : plan.run(kUndistortScans, mapping.drive, mapping.trajectory);
  // From here on a scan is as if it had been measured at once.
  compile.points = plan.run_as("", kRemoveMoving, moving, compile.undistorted, mapping.trajectory);
  // From here on all that is left stood still.
  if (!config.later_mapping.empty()) {
    compile.tile_drives = plan.run(kCountDrives, mapping.drive, mapping.trajectory, compile.points);
  }
  compile.ndt = plan.run(kBuildNdt, compile.points);
  compile.packed_nds = plan.run(kPackNds, compile.ndt);
  compile.surface = plan.run(kBuildSurface, compile.points);
  compile.sharpness = plan.run(
      kMeasureSharpness, is_one_sensor ? compile.undistorted : compile.drive, compile.trajectory);
  compile.sites = plan.run_as("", kChooseSites, route, compile.drive, compile.trajectory);
  return add_factors(localizing_sensor, compile);
}

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
  compile.packed_nds = plan.run(kPackNds, compile.ndt);
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
  compile.factors =
      plan.run(kAddMappingError, map_factors, compile.simulated, {}, compile.localizing_sensor);
}

}  // namespace sightline
