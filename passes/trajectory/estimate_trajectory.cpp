#include "passes/trajectory/estimate_trajectory.h"

#include <algorithm>
#include <utility>

#include "passes/trajectory/estimate_given.h"
#include "passes/trajectory/estimate_undistorted.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/following/smoothed_ways.h"
#include "passes/trajectory/following/unconstrained.h"
#include "passes/trajectory/graph/check_poses.h"
#include "passes/trajectory/graph/plane_adjustment.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/graph/scan_graph.h"
#include "passes/trajectory/pieces/join_pieces.h"

// How the poses of a drive are estimated, in the order of the steps: 1 odometry, 2 pieces, 3 loops,
// 4 pose graph, 5 planes, 6 the vehicle's poses; 7 all of them again with scans that are
// undistorted by the poses found; 8 checks by loops and scale. Each step is a function of a folder.
// following/ uses local/; sweep/ uses local/; given/ and pieces/ use following/ and local/; graph/
// uses given/, pieces/, following/ and local/; released/, for drives beside an earlier map, uses
// graph/ and local/. Numbers and limits are in schemas/definitions.md, "Trajectories". Sources:
//
//   Biber, Strasser, "The normal distributions transform", IROS 2003; in 3D: Magnusson, "The
//     three-dimensional normal-distributions transform", thesis, Orebro 2009
//   Vizzo et al., "KISS-ICP", RA-L 2023: constant velocity and a local map suffice for odometry
//   Hess et al., "Real-time loop closure in 2D LIDAR SLAM", ICRA 2016: branch and bound
//   Tuna et al., "X-ICP: Localizability-aware LiDAR registration", T-RO 2023
//   Rauch, Tung, Striebel, "Maximum likelihood estimates of linear dynamic systems", 1965
//   Kim, Kim, "Scan Context", IROS 2018: ring keys of places
//   Lu, Milios, "Globally consistent range scan alignment for environment mapping", 1997: pose
//     graphs
//   Huber, "Robust estimation of a location parameter", 1964
//   Zhou, Koppel, Kaess, "LiDAR SLAM with plane adjustment for indoor environment", RA-L 2021
//   Zhang, Singh, "LOAM: Lidar odometry and mapping in real-time", RSS 2014: undistorting by the
//     motion between poses
//   Droeschel, Stueckler, Behnke, ICRA 2014; Razlaw et al., ECMR 2015: map entropy as sharpness

namespace sightline {
namespace {

// Whether planes move the poses. Where no given pose distorts the way, matching each scan to many
// at once is nearer to the truth: planes bend a straight street, and give only the covariance.
// Pieces that few loops hold, and scans that a wide search found, are moved to fit the planes.
PlaneUse plane_use(const Odometry& odometry, const Connections& connections, bool refines) {
  const bool is_connected = are_connected(odometry, connections.pieces.edges, connections.edges());
  const bool has_far = std::ranges::count(odometry.is_far, true) > 0;
  return refines || !is_connected || has_far ? PlaneUse::kPoses : PlaneUse::kCovariance;
}

// Adds what steps at constant speed leave unknown.
void add_forecasts(const Drive& drive, const Odometry& odometry, Adjustment& adjusted) {
  const std::vector<Matrix6d> more =
      forecast_covariance(odometry, adjusted.T_map_lidar, drive.sensor.T_vehicle_lidar.inverse());
  for (std::size_t k = 0; k < more.size(); ++k) {
    if (!more[k].isZero(0.0)) adjusted.covariance[k] += more[k];
  }
}

// Steps 2 to 6 of an odometry, with `given` poses as priors.
Result<Estimate> solved(const EstimateTask& task, const GivenPoses& given, Odometry odometry) {
  const auto& [ctx, options, drive] = task;
  const bool refines =
      std::ranges::any_of(given, [](const auto& pose) { return pose.has_value(); });
  start_at_given(given, odometry);
  if (lead_to_all(given)) {
    SIGHTLINE_ASSIGN(odometry.overlap, overlaps_along(ctx, drive, options.local_map_m, odometry));
  }
  SIGHTLINE_TRY(check_following(drive, odometry));

  // 2. Pieces. Where nothing leads from one scan to the next, scans of the later piece are searched
  // in maps of the earlier ones, at all headings (Hess et al.), in places with similar ring keys
  // (Kim, Kim) first. Several must agree, and scans all along the piece must fit.
  //
  // 3. Loops. A scan near an earlier visit, by odometry and its drift, is matched to a map of that
  // visit; a sure match is an edge of the pose graph.
  SIGHTLINE_ASSIGN(const Connections connections, connect_scans(task, given, odometry));

  // 4. Pose graph (Lu, Milios): least squares over steps, joins, loops and given poses, the latter
  // three with Huber's loss. Given poses share their error over 100 m of way.
  const PoseGraph graph = graph_of_scans(task, given, odometry, connections);
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, odometry.T_map_lidar));

  // 5. Planes (Zhou et al.): the distances of points from small planes that several scans measured
  // move the key scans or give their covariance.
  SIGHTLINE_ASSIGN(
      Adjustment adjusted,
      adjust_to_planes(ctx, drive, key_graph_of(task, given, odometry, graph, solution.T_map_pose),
                       solution.T_map_pose, plane_use(odometry, connections, refines)));

  add_forecasts(drive, odometry, adjusted);

  // 6. The vehicle's poses, and the loops that they contradict.
  Estimate estimate{solved_trajectory(drive.frame, graph, solution), {}};
  estimate.trajectory.source = refines ? PoseSource::kRefined : PoseSource::kEstimated;
  estimate.trajectory.poses = vehicle_poses(drive, adjusted, odometry, connections.pieces.piece);
  mark_unconstrained(odometry, estimate.trajectory.poses);
  estimate.contradictions = find_contradictions(odometry, connections.loops, adjusted.T_map_lidar);
  warn_of_unmatched(ctx, odometry);
  return estimate;
}

SolvePoses solver_of(const EstimateTask& task) {
  return [task](const GivenPoses& given, const Odometry& odometry) {
    return solved(task, given, odometry);
  };
}

// Poses without any that are given.
Result<Estimate> estimated(const EstimateTask& task) {
  const auto& [ctx, options, drive] = task;
  const GivenPoses none(drive.scans.size());

  // 1. Odometry: each scan is matched by NDT (Biber, Strasser; Magnusson) to a map of the last 50 m
  // of way, from where constant velocity leads (Vizzo et al.); where too few of its upright points
  // meet that map, it is searched for farther around. Motions that the surfaces a scan meets do not
  // constrain (Tuna et al.) are those of the given poses or of constant velocity.
  // Where the vehicle's wheels or its inertial unit measured the motion, they replace constant
  // velocity, with what was measured behind each stretch too (Rauch, Tung, Striebel).
  SIGHTLINE_ASSIGN(Odometry odometry, run_odometry(ctx, options.local_map_m, drive, none));
  smooth_forecasts(ctx, drive, odometry);
  return solved(task, none, std::move(odometry));
}

// What the poses of a drive are made of.
enum class PosesFrom { kGiven, kGivenAndScans, kScans };

// Receivers have other errors on another day: given poses of several drives are refined together.
PosesFrom poses_from(const EstimateTrajectoryOptions& options, const Drive& drive) {
  if (options.mode == PoseMode::kGiven) return PosesFrom::kGiven;
  if (options.mode == PoseMode::kEstimate) return PosesFrom::kScans;
  if (options.mode == PoseMode::kAuto && drive.has_poses() && drive.later_parts.empty()) {
    return PosesFrom::kGiven;
  }
  const bool has_given = std::ranges::any_of(
      drive.scans, [](const ScanInfo& scan) { return scan.T_world_vehicle.has_value(); });
  return has_given ? PosesFrom::kGivenAndScans : PosesFrom::kScans;
}

Result<Estimate> estimate_by(const EstimateTask& task, PosesFrom from) {
  // Given poses are compared with odometry, and kept unless refined ones are sharper (Droeschel et
  // al.; Razlaw et al.).
  if (from == PosesFrom::kGiven) {
    SIGHTLINE_ASSIGN(const StraightDrive straight, undistorted_by_given(task.ctx, task.drive));
    const EstimateTask by_straight{task.ctx, task.options, straight.drive};
    return check_given(by_straight, straight.uneven_rad, solver_of(by_straight));
  }
  const EstimatePoses by_rigid_scans = [&](PassContext& ctx, const Drive& drive) {
    const EstimateTask of_drive{ctx, task.options, drive};
    return from == PosesFrom::kScans ? estimated(of_drive)
                                     : refine_given(of_drive, solver_of(of_drive));
  };
  SIGHTLINE_ASSIGN(const Estimate rigid, by_rigid_scans(task.ctx, task.drive));

  // 7. Scans with times, of their own or by the order of their points, are undistorted with these
  // poses (Zhang, Singh) and all steps are repeated; the sharper estimate is kept.
  return estimate_undistorted(task.ctx, task.drive, rigid, by_rigid_scans);
}

}  // namespace

std::vector<OptionField> option_fields(EstimateTrajectoryOptions& options) {
  return {
      choice("mode", options.mode,
             "source of the poses: as given; given and refined by the scans; estimated from the "
             "scans; auto: as given for one drive, refined for several, estimated where none are "
             "given",
             {"auto", "given", "refine", "estimate"}),
      choice("bad_poses", options.bad_poses,
             "action where given poses contradict the motion in the scans",
             {"ignore", "warn", "repair", "refuse"}),
      number("prior_sigma_m", options.prior_sigma_m,
             "when refining: standard deviation of given positions, m", 0.001, 1000.0),
      number("prior_sigma_deg", options.prior_sigma_deg,
             "when refining: standard deviation of given headings, degrees", 0.001, 180.0),
      number("prior_correlation_m", options.prior_correlation_m,
             "when refining: distance over which errors of given poses are correlated, m", 0.0,
             10000.0),
      number("local_map_m", options.local_map_m,
             "length of route whose scans form the local map for matching, m", 5.0, 500.0),
      flag("closes_loops", options.closes_loops,
           "match scans again where the route returns to a place (loop closure)"),
  };
}

Result<Trajectory> estimate_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                       const Drive& drive) {
  const PosesFrom from = poses_from(options, drive);
  if (options.mode == PoseMode::kRefine && from == PosesFrom::kScans) {
    return Error{
        ErrorCode::kNoPoses,
        "the recording has no poses to refine; set estimate-trajectory.mode=auto or estimate", "",
        "drive " + drive.name};
  }
  SIGHTLINE_ASSIGN(Estimate answer, estimate_by({ctx, options, drive}, from));

  // 8. The poses are checked by the loops that contradict them, and by how large drives measure the
  // same walls. Stretches that the scans do not constrain are named.
  warn_of_unconstrained(ctx, drive.name, answer.trajectory);
  warn_of_contradictions(ctx, drive, answer.contradictions, answer.trajectory.notices);
  SIGHTLINE_TRY(warn_of_scale_differences(ctx, drive, answer.trajectory));
  return std::move(answer.trajectory);
}

}  // namespace sightline
