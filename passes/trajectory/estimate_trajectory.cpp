#include "passes/trajectory/estimate_trajectory.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "passes/trajectory/estimate_undistorted.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/following/overlaps.h"
#include "passes/trajectory/given/given_trajectory.h"
#include "passes/trajectory/graph/contradictions.h"
#include "passes/trajectory/graph/drive_scales.h"
#include "passes/trajectory/graph/loops.h"
#include "passes/trajectory/graph/plane_adjustment.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/graph/scan_graph.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/pieces/join_pieces.h"
#include "passes/trajectory/pieces/tell_pieces.h"
#include "passes/trajectory/pieces/tied_pieces.h"
#include "passes/trajectory/sweep/turn_trial.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

Trajectory trajectory_of(const Drive& drive, const PoseGraph& graph, const GraphSolution& solution,
                         const Adjustment& adjusted) {
  Trajectory trajectory;
  trajectory.frame = drive.frame;
  trajectory.odometry_edges = static_cast<std::uint32_t>(graph.odometry.size());
  trajectory.loop_edges = static_cast<std::uint32_t>(graph.loops.size());
  trajectory.prior_edges = static_cast<std::uint32_t>(graph.priors.size());
  trajectory.rms_translation_residual_m = solution.rms_translation_m;
  trajectory.rms_rotation_residual_rad = solution.rms_rotation_rad;
  const Pose T_lidar_vehicle = drive.sensor.T_vehicle_lidar.inverse();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    TrajectoryPose pose{drive.scans[i].recording_index, drive.scans[i].stamp_ns,
                        adjusted.T_map_lidar[i] * T_lidar_vehicle};
    const Eigen::Vector3d arm_m =
        pose.T_map_vehicle.translation() - adjusted.T_map_lidar[i].translation();
    pose.covariance = moved_by(arm_m, adjusted.covariance[i]);
    trajectory.poses.push_back(pose);
  }
  return trajectory;
}

// Poses of odometry laid on the first given one, from where the graph moves them little.
Odometry laid_on(const std::vector<std::optional<Pose>>& given, Odometry odometry) {
  const auto first = std::ranges::find_if(given, [](const auto& pose) { return bool(pose); });
  if (first == given.end() || first == given.begin()) return odometry;
  const auto number = static_cast<std::size_t>(first - given.begin());
  const Pose T_given_found = **first * odometry.T_map_lidar[number].inverse();
  for (Pose& pose : odometry.T_map_lidar) pose = T_given_found * pose;
  return odometry;
}

// Estimates that loops contradict. A drive is estimated several times, and which of the estimates
// is the answer turns out last: then whoever has it can say so.
class ContradictedEstimates {
 public:
  void add(const Trajectory& estimate, std::vector<Contradiction> found) {
    if (!found.empty()) estimates_.emplace_back(estimate.poses, std::move(found));
  }
  void warn_of(const PassContext& ctx, const Drive& drive, const Trajectory& answer) const {
    const auto is_answer = [&](const auto& estimate) {
      return std::ranges::equal(estimate.first, answer.poses, [](const auto& a, const auto& b) {
        return a.T_map_vehicle.matrix() == b.T_map_vehicle.matrix();
      });
    };
    const auto contradicted = std::ranges::find_if(estimates_, is_answer);
    if (contradicted == estimates_.end()) return;
    warn_of_contradictions(ctx, drive, contradicted->second);
  }

 private:
  std::vector<std::pair<std::vector<TrajectoryPose>, std::vector<Contradiction>>> estimates_;
};

// By odometry and, where `given` has them, given poses.
Result<Trajectory> solved_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                     const Drive& drive,
                                     const std::vector<std::optional<Pose>>& given,
                                     const Odometry& found, ContradictedEstimates& contradicted) {
  const bool refines = std::ranges::any_of(given, [](const auto& pose) { return bool(pose); });
  Odometry odometry = laid_on(given, found);
  if (lead_to_all(given)) {
    SIGHTLINE_ASSIGN(odometry.overlap, overlaps_along(ctx, drive, options.local_map_m, odometry));
  }
  SIGHTLINE_TRY(check_following(drive, odometry));
  SIGHTLINE_ASSIGN(const JoinedPieces pieces, join_pieces(ctx, drive, given, odometry));
  warn_of_pieces(ctx, drive, odometry, pieces);
  const std::vector<std::uint32_t> scans = all_scans(odometry);
  const double way_m = odometry.driven_m.back();
  PoseGraph graph{steps_of(odometry, scans), pieces.edges, priors_of(options, way_m, given, scans),
                  pieces.held};
  std::vector<GraphEdge> loops;
  if (options.closes_loops) {
    SIGHTLINE_ASSIGN(loops, find_loops(ctx, drive, odometry));
    graph.loops.insert(graph.loops.end(), loops.begin(), loops.end());
  }
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, odometry.T_map_lidar));
  const std::vector<std::uint32_t> keys = key_scans(odometry);
  const PoseGraph key_graph =
      graph_of_keys(graph, odometry, priors_of(options, way_m, given, keys), keys);
  // Where no given pose pulls the way out of shape, matching each scan to many at once is nearer to
  // the truth than planes are, which lend it only their covariance: they bend a straight street.
  // What hangs by a scan that was found from afar is set right by planes.
  const bool is_loose = !are_tied(odometry, pieces.edges, graph.loops) ||
                        std::ranges::count(odometry.is_far, true) > 0;
  const auto by_planes = refines || is_loose ? adjust_to_planes : weigh_by_planes;
  SIGHTLINE_ASSIGN(const Adjustment adjusted,
                   by_planes(ctx, drive, key_graph, solution.T_map_pose, keys));
  Trajectory trajectory = trajectory_of(drive, graph, solution, adjusted);
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    trajectory.poses[i].piece = pieces.piece[i];
    trajectory.poses[i].overlap = odometry.overlap[i];
  }
  trajectory.source = refines ? PoseSource::kRefined : PoseSource::kEstimated;
  contradicted.add(trajectory, find_contradictions(odometry, loops, adjusted.T_map_lidar));
  const auto unmatched = std::ranges::count(odometry.is_matched, false) -
                         static_cast<std::ptrdiff_t>(odometry.piece_starts.size());
  if (unmatched > 0) {
    ctx.warn(std::to_string(unmatched) +
             " scans could not be matched to those before them and follow the given poses");
  }
  return trajectory;
}

TrajectorySolver solver_of(PassContext& ctx, const EstimateTrajectoryOptions& options,
                           const Drive& drive, ContradictedEstimates& contradicted) {
  return [&](const std::vector<std::optional<Pose>>& given, const Odometry& odometry) {
    return solved_trajectory(ctx, options, drive, given, odometry, contradicted);
  };
}

// The scans by which given poses are judged: as they are, or, where turn rates tell how the vehicle
// turned within them, undistorted by the given poses. Else poses that are right would seem to
// contradict scans that are drawn out unevenly.
Result<Drive> as_given_poses_see(PassContext& ctx, const Drive& drive) {
  const bool has_times =
      std::ranges::any_of(drive.scans, [](const ScanInfo& scan) { return scan.has_point_times; });
  if (drive.turn_rates.empty() || !has_times || !drive.has_poses()) return drive;
  SIGHTLINE_ASSIGN(const Trajectory given, trajectory_as_given(drive));
  PassContext quiet;  // undistort-scans warns
  quiet.threads = ctx.threads;
  std::vector<Drive> parts = parts_of(drive);
  const std::vector<Trajectory> poses = trajectories_of_parts(parts, given);
  bool is_changed = false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    SIGHTLINE_ASSIGN(const Drive turned, with_turns_that_pay(quiet, parts[i], poses[i]));
    if (turned.turn_rates.empty()) continue;
    parts[i] = undistorted(turned, poses[i]);
    is_changed = true;
  }
  return is_changed ? joined_again(drive, parts) : drive;
}

}  // namespace

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options) {
  return {
      choice("mode", options.mode, "where poses come from",
             {"auto", "given", "refine", "estimate"}),
      choice("bad_poses", options.bad_poses, "where given poses move otherwise than the scans show",
             {"ignore", "warn", "repair", "refuse"}),
      number("prior_sigma_m", options.prior_sigma_m,
             "when refining: how far off given positions are, m", 0.001, 1000.0),
      number("prior_sigma_deg", options.prior_sigma_deg,
             "when refining: how far off given headings are, degrees", 0.001, 180.0),
      number("prior_correlation_m", options.prior_correlation_m,
             "when refining: given poses share their error over this much of the way, m", 0.0,
             10000.0),
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
  // Receivers are off otherwise on another day: poses of several drives are refined together.
  const bool is_one = drive.later_parts.empty();
  ContradictedEstimates contradicted;
  if (options.mode == PoseMode::kGiven ||
      (options.mode == PoseMode::kAuto && drive.has_poses() && is_one)) {
    SIGHTLINE_ASSIGN(const Drive seen, as_given_poses_see(ctx, drive));
    SIGHTLINE_ASSIGN(
        const Trajectory checked,
        checked_trajectory(ctx, options, seen, solver_of(ctx, options, seen, contradicted)));
    contradicted.warn_of(ctx, drive, checked);
    SIGHTLINE_ASSIGN(const std::vector<ScaleDifference> scales,
                     find_scale_differences(ctx, drive, checked));
    warn_of_scale_differences(ctx, drive, scales);
    return checked;
  }
  if (options.mode == PoseMode::kRefine && !some_given) {
    return Error{ErrorCode::kNoPoses, "the recording gives no poses to refine", "",
                 "drive " + drive.name};
  }
  const bool refines = some_given && options.mode != PoseMode::kEstimate;
  const EstimatePoses estimate = [&](PassContext& own, const Drive& scans) -> Result<Trajectory> {
    const TrajectorySolver solve = solver_of(own, options, scans, contradicted);
    if (refines) return refined_trajectory(own, options, scans, solve);
    const std::vector<std::optional<Pose>> none(scans.scans.size());
    SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(own, options.local_map_m, scans, none));
    return solve(none, odometry);
  };
  SIGHTLINE_ASSIGN(const Trajectory rigid, estimate(ctx, drive));
  SIGHTLINE_ASSIGN(const Trajectory answer, estimate_undistorted(ctx, drive, rigid, estimate));
  contradicted.warn_of(ctx, drive, answer);
  SIGHTLINE_ASSIGN(const std::vector<ScaleDifference> scales,
                   find_scale_differences(ctx, drive, answer));
  warn_of_scale_differences(ctx, drive, scales);
  return answer;
}

}  // namespace sightline
