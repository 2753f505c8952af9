#include "passes/estimate_trajectory.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "passes/estimate_trajectory_graph.h"
#include "passes/estimate_trajectory_loops.h"
#include "passes/estimate_trajectory_odometry.h"

namespace sightline {
namespace {

// Of one step of odometry; measured on generated towns: about 3 mm and 0.03 degrees.
constexpr double kStepSigma_m = 0.005;
constexpr double kStepSigma_rad = 0.0005;
// Of a step that could not be matched and follows the given poses.
constexpr double kUnmatchedSigma_m = 0.5;
constexpr double kUnmatchedSigma_rad = 0.05;

Result<Trajectory> given_trajectory(const Drive& drive) {
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  for (const ScanInfo& scan : drive.scans) {
    if (!scan.T_world_vehicle) {
      return Error{ErrorCode::kNoPoses, "the recording gives no pose of this scan", scan.source,
                   "scan " + std::to_string(scan.recording_index)};
    }
    trajectory.poses.push_back({scan.recording_index, scan.stamp_ns,
                                rebase(*scan.T_world_vehicle, MapFrame{}, drive.frame)});
  }
  return trajectory;
}

// T_map_lidar of each scan as given, none where it is not wanted or not there.
std::vector<std::optional<Pose>> given_poses(const Drive& drive, bool wanted) {
  std::vector<std::optional<Pose>> given(drive.scans.size());
  for (std::size_t i = 0; wanted && i < given.size(); ++i) {
    if (!drive.scans[i].T_world_vehicle) continue;
    given[i] = rebase(*drive.scans[i].T_world_vehicle, MapFrame{}, drive.frame) *
               drive.sensor.T_vehicle_lidar;
  }
  return given;
}

PoseGraph graph_of(const EstimateTrajectoryOptions& options, const Odometry& odometry,
                   const std::vector<std::optional<Pose>>& given) {
  PoseGraph graph;
  for (std::uint32_t k = 1; k < odometry.T_map_lidar.size(); ++k) {
    const bool is_matched = odometry.is_matched[k];
    GraphEdge edge;
    edge.from = k - 1;
    edge.to = k;
    edge.T_from_to = odometry.T_map_lidar[k - 1].inverse() * odometry.T_map_lidar[k];
    edge.sigma_m = is_matched ? kStepSigma_m : kUnmatchedSigma_m;
    edge.sigma_rad = is_matched ? kStepSigma_rad : kUnmatchedSigma_rad;
    graph.odometry.push_back(edge);
  }
  for (std::uint32_t k = 0; k < given.size(); ++k) {
    if (!given[k]) continue;
    graph.priors.push_back(
        {k, *given[k], options.prior_sigma_m, options.prior_sigma_deg * std::numbers::pi / 180.0});
  }
  return graph;
}

Result<Trajectory> matched_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, bool refines) {
  const std::vector<std::optional<Pose>> given = given_poses(drive, refines);
  const Result<Odometry> odometry = run_odometry(ctx, options.local_map_m, drive, given);
  if (!odometry) return odometry.error();
  PoseGraph graph = graph_of(options, *odometry, given);
  if (options.closes_loops) {
    Result<std::vector<GraphEdge>> loops = find_loops(ctx, drive, *odometry);
    if (!loops) return loops.error();
    graph.loops = std::move(*loops);
  }
  const Result<GraphSolution> solution = solve_pose_graph(graph, odometry->T_map_lidar);
  if (!solution) return solution.error();
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  trajectory.source = refines ? PoseSource::kRefined : PoseSource::kEstimated;
  trajectory.odometry_edges = static_cast<std::uint32_t>(graph.odometry.size());
  trajectory.loop_edges = static_cast<std::uint32_t>(graph.loops.size());
  trajectory.prior_edges = static_cast<std::uint32_t>(graph.priors.size());
  trajectory.rms_translation_residual_m = solution->rms_translation_m;
  trajectory.rms_rotation_residual_rad = solution->rms_rotation_rad;
  const Pose T_lidar_vehicle = drive.sensor.T_vehicle_lidar.inverse();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    trajectory.poses.push_back({drive.scans[i].recording_index, drive.scans[i].stamp_ns,
                                solution->T_map_pose[i] * T_lidar_vehicle});
  }
  const auto unmatched = std::ranges::count(odometry->is_matched, false);
  if (unmatched > 0) {
    ctx.warn(std::to_string(unmatched) +
             " scans could not be matched to those before them and follow the given poses");
  }
  return trajectory;
}

}  // namespace

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options) {
  return {
      choice("mode", options.mode, "where poses come from",
             {"auto", "given", "refine", "estimate"}),
      number("prior_sigma_m", options.prior_sigma_m,
             "when refining: how far off given positions are, m", 0.001, 1000.0),
      number("prior_sigma_deg", options.prior_sigma_deg,
             "when refining: how far off given headings are, degrees", 0.001, 180.0),
      number("local_map_m", options.local_map_m,
             "scans are matched to what was seen on this much of the way, m", 5.0, 500.0),
      flag("closes_loops", options.closes_loops,
           "match again where the route comes back to a place"),
  };
}

Result<Trajectory> estimate_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                       const Drive& drive) {
  const bool some_given = std::ranges::any_of(
      drive.scans, [](const ScanInfo& scan) { return scan.T_world_vehicle.has_value(); });
  if (options.mode == "given" || (options.mode == "auto" && drive.has_poses())) {
    return given_trajectory(drive);
  }
  if (options.mode == "refine" && !some_given) {
    return Error{ErrorCode::kNoPoses, "the recording gives no poses to refine", "",
                 "drive " + drive.name};
  }
  return matched_trajectory(ctx, options, drive, some_given && options.mode != "estimate");
}

}  // namespace sightline
