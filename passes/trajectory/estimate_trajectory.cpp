#include "passes/trajectory/estimate_trajectory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "formats/rotation.h"
#include "passes/trajectory/disagreements.h"
#include "passes/trajectory/loops.h"
#include "passes/trajectory/odometry.h"
#include "passes/trajectory/plane_adjustment.h"
#include "passes/trajectory/pose_graph.h"
#include "passes/trajectory/swept_drive.h"

namespace sightline {
namespace {

// Of one step of odometry; measured on generated towns: about 3 mm and 0.03 degrees.
constexpr double kStepSigma_m = 0.005;
constexpr double kStepSigma_rad = 0.0005;
// Of a step that could not be matched and follows the given poses.
constexpr double kUnmatchedSigma_m = 0.5;
constexpr double kUnmatchedSigma_rad = 0.05;
// Between scans that are adjusted; those between follow.
constexpr double kKeyStep_m = 2.0;
constexpr double kKeyTurn_rad = 0.1;

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

// Errors of given poses vary slowly: those on one stretch of this length share theirs, and together
// they say no more than one.
double shared_by(const EstimateTrajectoryOptions& options, double way_m, std::size_t poses) {
  return std::max(1.0, static_cast<double>(poses) * options.prior_correlation_m /
                           std::max(way_m, options.prior_correlation_m));
}

std::vector<GraphPrior> priors_of(const EstimateTrajectoryOptions& options, double way_m,
                                  const std::vector<std::optional<Pose>>& given,
                                  const std::vector<std::uint32_t>& scans) {
  std::vector<GraphPrior> priors;
  for (std::uint32_t i = 0; i < scans.size(); ++i) {
    const std::optional<Pose>& pose = given[scans[i]];
    if (pose) priors.push_back({i, *pose, options.prior_sigma_m, options.prior_sigma_deg});
  }
  const double more = std::sqrt(shared_by(options, way_m, priors.size()));
  for (GraphPrior& prior : priors) {
    prior.sigma_m *= more;
    prior.sigma_rad *= more * std::numbers::pi / 180.0;
  }
  return priors;
}

std::vector<std::uint32_t> all_scans(const Odometry& odometry) {
  std::vector<std::uint32_t> scans(odometry.T_map_lidar.size());
  std::iota(scans.begin(), scans.end(), 0u);
  return scans;
}

// Scans far enough from each other to be worth adjusting: with the first and the last one.
std::vector<std::uint32_t> key_scans(const Odometry& odometry) {
  std::vector<std::uint32_t> keys;
  const std::size_t count = odometry.T_map_lidar.size();
  for (std::uint32_t k = 0; k < count; ++k) {
    const bool is_far = keys.empty() ||
                        odometry.driven_m[k] - odometry.driven_m[keys.back()] >= kKeyStep_m ||
                        rotation_angle_rad(odometry.T_map_lidar[keys.back()].linear().transpose() *
                                           odometry.T_map_lidar[k].linear()) >= kKeyTurn_rad;
    if (is_far || k + 1 == count) keys.push_back(k);
  }
  return keys;
}

// Steps of odometry from each of `scans` to the next.
std::vector<GraphEdge> steps_of(const Odometry& odometry, const std::vector<std::uint32_t>& scans) {
  std::vector<GraphEdge> steps;
  for (std::uint32_t i = 1; i < scans.size(); ++i) {
    bool is_matched = true;
    for (std::uint32_t k = scans[i - 1] + 1; k <= scans[i]; ++k) {
      is_matched = is_matched && odometry.is_matched[k];
    }
    GraphEdge edge;
    edge.from = i - 1;
    edge.to = i;
    edge.T_from_to = odometry.T_map_lidar[scans[i - 1]].inverse() * odometry.T_map_lidar[scans[i]];
    const double count = std::sqrt(static_cast<double>(scans[i] - scans[i - 1]));
    edge.sigma_m = count * (is_matched ? kStepSigma_m : kUnmatchedSigma_m);
    edge.sigma_rad = count * (is_matched ? kStepSigma_rad : kUnmatchedSigma_rad);
    steps.push_back(edge);
  }
  return steps;
}

// The same graph between keys only; loops move to the nearest key before.
PoseGraph graph_of_keys(const PoseGraph& graph, const Odometry& odometry,
                        std::vector<GraphPrior> priors, const std::vector<std::uint32_t>& keys) {
  PoseGraph reduced;
  reduced.odometry = steps_of(odometry, keys);
  reduced.priors = std::move(priors);
  const auto key_before = [&](std::uint32_t scan) {
    const auto after = std::ranges::upper_bound(keys, scan);
    return static_cast<std::uint32_t>(after - keys.begin() - 1);
  };
  for (GraphEdge loop : graph.loops) {
    const std::uint32_t from = key_before(loop.from);
    const std::uint32_t to = key_before(loop.to);
    const std::vector<Pose>& poses = odometry.T_map_lidar;
    loop.T_from_to = poses[keys[from]].inverse() * poses[loop.from] * loop.T_from_to *
                     poses[loop.to].inverse() * poses[keys[to]];
    loop.from = from;
    loop.to = to;
    if (from != to) reduced.loops.push_back(loop);
  }
  return reduced;
}

// The covariance of a point of the vehicle that is `arm_m` from the one it is known of, map axes.
Matrix6d moved_by(const Eigen::Vector3d& arm_m, const Matrix6d& covariance) {
  Matrix6d by_motion = Matrix6d::Identity();
  by_motion.block<3, 3>(0, 3) << 0.0, arm_m.z(), -arm_m.y(), -arm_m.z(), 0.0, arm_m.x(), arm_m.y(),
      -arm_m.x(), 0.0;
  const Matrix6d there = by_motion * covariance * by_motion.transpose();
  return 0.5 * (there + there.transpose());
}

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

Result<Trajectory> matched_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive, bool refines) {
  const std::vector<std::optional<Pose>> given = given_poses(drive, refines);
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  const std::vector<std::uint32_t> scans = all_scans(odometry);
  const double way_m = odometry.driven_m.back();
  PoseGraph graph{steps_of(odometry, scans), {}, priors_of(options, way_m, given, scans)};
  if (options.closes_loops) {
    SIGHTLINE_ASSIGN(std::vector<GraphEdge> loops, find_loops(ctx, drive, odometry));
    graph.loops = std::move(loops);
  }
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, odometry.T_map_lidar));
  const std::vector<std::uint32_t> keys = key_scans(odometry);
  const PoseGraph key_graph =
      graph_of_keys(graph, odometry, priors_of(options, way_m, given, keys), keys);
  SIGHTLINE_ASSIGN(Adjustment adjusted,
                   adjust_to_planes(ctx, drive, key_graph, solution.T_map_pose, keys));
  // Where no given pose pulls the way out of shape, matching each scan to many at once is nearer to
  // the truth than planes are, which lend it only their covariance.
  if (!refines) adjusted.T_map_lidar = solution.T_map_pose;
  Trajectory trajectory = trajectory_of(drive, graph, solution, adjusted);
  trajectory.source = refines ? PoseSource::kRefined : PoseSource::kEstimated;
  const auto unmatched = std::ranges::count(odometry.is_matched, false);
  if (unmatched > 0) {
    ctx.warn(std::to_string(unmatched) +
             " scans could not be matched to those before them and follow the given poses");
  }
  return trajectory;
}

// Says where given poses and scans disagree; true where it found such a place.
Result<bool> check_given(PassContext& ctx, const EstimateTrajectoryOptions& options,
                         const Drive& drive) {
  constexpr std::size_t kMostTold = 5;
  const std::vector<std::optional<Pose>> given = given_poses(drive, true);
  SIGHTLINE_ASSIGN(const Odometry odometry, run_odometry(ctx, options.local_map_m, drive, given));
  const std::vector<PoseDisagreement> found = find_disagreements(given, odometry);
  if (found.empty()) return false;
  std::string text = "given poses and scans disagree on " + std::to_string(found.size()) +
                     " stretches of drive " + drive.name;
  for (std::size_t i = 0; i < std::min(found.size(), kMostTold); ++i) {
    text += (i == 0 ? ": " : "; ") + to_text(found[i], drive);
  }
  if (options.bad_poses == BadPoses::kRefuse) {
    return Error{ErrorCode::kMismatchedInputs, text, drive.scans[found[0].first].source,
                 "scan " + std::to_string(drive.scans[found[0].first].recording_index)};
  }
  ctx.warn(text + (options.bad_poses == BadPoses::kRepair
                       ? ". They are refined"
                       : ". They are used all the same; "
                         "estimate-trajectory.bad_poses=repair refines "
                         "them"));
  return true;
}

Result<Trajectory> checked_trajectory(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                      const Drive& drive) {
  Result<Trajectory> given = given_trajectory(drive);
  if (!given || options.bad_poses == BadPoses::kIgnore || drive.scans.size() < 2) return given;
  SIGHTLINE_ASSIGN(const bool is_bad, check_given(ctx, options, drive));
  if (is_bad && options.bad_poses == BadPoses::kRepair) {
    return matched_trajectory(ctx, options, drive, true);
  }
  return given;
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
  if (options.mode == PoseMode::kGiven || (options.mode == PoseMode::kAuto && drive.has_poses())) {
    return checked_trajectory(ctx, options, drive);
  }
  if (options.mode == PoseMode::kRefine && !some_given) {
    return Error{ErrorCode::kNoPoses, "the recording gives no poses to refine", "",
                 "drive " + drive.name};
  }
  const EstimatePoses estimate = [&](PassContext& own, const Drive& scans) {
    return matched_trajectory(own, options, scans,
                              some_given && options.mode != PoseMode::kEstimate);
  };
  SIGHTLINE_ASSIGN(const Trajectory rigid, estimate(ctx, drive));
  return estimate_undistorted(ctx, drive, rigid, estimate);
}

}  // namespace sightline
