#include "passes/trajectory/released/extend_released.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/drive/trajectory_of_drive.h"
#include "formats/grid/point_grid.h"
#include "passes/matching/match_score.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/contradictions.h"
#include "passes/trajectory/graph/drive_scales.h"
#include "passes/trajectory/graph/loops.h"
#include "passes/trajectory/graph/plane_adjustment.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/graph/scan_graph.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/local/stretch_of_drive.h"
#include "passes/trajectory/pieces/join_pieces.h"
#include "passes/trajectory/pieces/tell_pieces.h"
#include "passes/trajectory/pieces/tied_pieces.h"
#include "passes/trajectory/undistort_scans.h"

namespace sightline {
namespace {

constexpr const char* kPlace = "pass estimate-trajectory";

// How many scans from the first on were released: those of whole parts.
Result<std::size_t> count_released(const Drive& drive,
                                   const std::vector<const TrajectoryPose*>& poses) {
  std::vector<std::size_t> known(drive.later_parts.size() + 1);
  std::vector<std::size_t> all(known.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ++all[drive.scans[i].part];
    if (poses[i]) ++known[drive.scans[i].part];
  }
  std::size_t count = 0;
  for (std::uint32_t part = 0; part < known.size(); ++part) {
    const std::string& name = drive.name_of_part(part);
    if (known[part] == 0) continue;
    if (known[part] < all[part]) {
      return Error{ErrorCode::kMismatchedInputs,
                   std::to_string(known[part]) + " of its " + std::to_string(all[part]) +
                       " scans have released poses: it is not the recording that was shipped",
                   "", "drive " + name};
    }
    count += all[part];
    if (part > 0 && known[part - 1] == 0) {
      return Error{ErrorCode::kBadValue,
                   "it is released and named behind drive " + drive.name_of_part(part - 1) +
                       ", which is not; name new drives last",
                   "", "drive " + name};
    }
  }
  if (count > 0) return count;
  return Error{ErrorCode::kMismatchedInputs,
               "none of the drives " + drive.names_of_parts() + " has released poses", "", kPlace};
}

// The parts of a drive from a scan on that begins one.
Drive parts_from(const Drive& drive, std::size_t first) {
  Drive later = stretch_of(drive, first, drive.scans.size() - first);
  const std::uint32_t part = drive.scans[first].part;
  later.name = drive.name_of_part(part);
  later.later_parts.assign(drive.later_parts.begin() + part, drive.later_parts.end());
  for (ScanInfo& scan : later.scans) scan.part -= part;
  return later;
}

// The poses of the first `count` scans.
Trajectory shipped_trajectory(const Drive& drive, const ReleasedPoses& released,
                              const std::vector<const TrajectoryPose*>& poses, std::size_t count) {
  Trajectory trajectory = rebase(released.trajectory, drive.frame);
  const TrajectoryPose* first = released.trajectory.poses.data();
  std::vector<TrajectoryPose> told;
  for (std::size_t i = 0; i < count; ++i) {
    TrajectoryPose pose = trajectory.poses[static_cast<std::size_t>(poses[i] - first)];
    pose.recording_index = drive.scans[i].recording_index;
    pose.stamp_ns = drive.scans[i].stamp_ns;
    told.push_back(pose);
  }
  // A drive may have been left out: pieces are numbered anew in the order of their first scans.
  std::vector<std::uint32_t> pieces;
  for (TrajectoryPose& pose : told) {
    auto number = std::ranges::find(pieces, pose.piece);
    if (number == pieces.end()) number = pieces.insert(number, pose.piece);
    pose.piece = static_cast<std::uint32_t>(number - pieces.begin());
  }
  trajectory.poses = std::move(told);
  return trajectory;
}

// What is known of all scans, as the odometry of one drive.
struct Followed {
  Odometry odometry;                  // its pieces are runs of scans of one known piece
  std::vector<std::uint32_t> of_run;  // the known piece of each
  std::uint32_t released_runs = 0;
  std::size_t first = 0;  // of the scans that are not released
};

void follow(const Drive& drive, const Trajectory& trajectory, std::uint32_t first_piece,
            Followed& followed) {
  Odometry& odometry = followed.odometry;
  const Pose& T_vehicle_lidar = drive.sensor.T_vehicle_lidar;
  for (const TrajectoryPose& pose : trajectory.poses) {
    const std::uint32_t piece = first_piece + pose.piece;
    const Pose T_map_lidar = pose.T_map_vehicle * T_vehicle_lidar;
    const bool is_first = followed.of_run.empty();
    const bool begins = is_first || followed.of_run.back() != piece;
    if (begins && !is_first) {
      odometry.piece_starts.push_back({static_cast<std::uint32_t>(odometry.piece.size()), true});
    }
    if (begins) followed.of_run.push_back(piece);
    const double step_m =
        begins ? 0.0
               : (T_map_lidar.translation() - odometry.T_map_lidar.back().translation()).norm();
    odometry.driven_m.push_back((is_first ? 0.0 : odometry.driven_m.back()) + step_m);
    odometry.T_map_lidar.push_back(T_map_lidar);
    odometry.is_matched.push_back(true);
    odometry.is_far.push_back(false);
    odometry.piece.push_back(static_cast<std::uint32_t>(followed.of_run.size() - 1));
    odometry.overlap.push_back(pose.overlap);
  }
}

Followed followed(const Drive& drive, const Trajectory& released, const Trajectory& own) {
  Followed all;
  follow(drive, released, 0, all);
  all.released_runs = static_cast<std::uint32_t>(all.of_run.size());
  all.first = released.poses.size();
  const std::uint32_t pieces = released.poses.back().piece + 1;
  follow(drive, own, std::max(pieces, *std::ranges::max_element(all.of_run) + 1), all);
  return all;
}

// All scans as if each had been measured at once; `released`: those that were released.
Result<Drive> straight_scans(PassContext& ctx, const Drive& drive, const Drive& released,
                             const Trajectory& own) {
  PassContext quiet;  // undistort-scans warns
  quiet.threads = ctx.threads;
  SIGHTLINE_ASSIGN(const Drive later,
                   undistort_scans(quiet, {}, parts_from(drive, released.scans.size()), own));
  std::vector<Drive> parts = parts_of(released);
  for (Drive& part : parts_of(later)) parts.push_back(std::move(part));
  return joined_again(drive, parts);
}

// Where given poses say how the other scans lie to the released ones: T_map_lidar of both.
std::vector<std::optional<Pose>> given_poses(const Drive& drive, const Trajectory& released,
                                             const Followed& all) {
  std::vector<std::optional<Pose>> given(drive.scans.size());
  if (released.source == PoseSource::kEstimated) return given;  // in a frame of their own
  const auto is_given = [&](std::size_t i) { return drive.scans[i].T_world_vehicle.has_value(); };
  bool has_later = false;
  for (std::size_t i = all.first; i < given.size(); ++i) has_later = has_later || is_given(i);
  // The trajectory of a drive with given poses lies where these say.
  for (std::size_t i = 0; has_later && i < given.size(); ++i) {
    if (i < all.first || is_given(i)) given[i] = all.odometry.T_map_lidar[i];
  }
  return given;
}

// The scans that are not released, numbered from 0, and what holds them.
PoseGraph graph_of_later(const Followed& all, const JoinedPieces& joined,
                         const std::vector<GraphEdge>& loops) {
  const auto first = static_cast<std::uint32_t>(all.first);
  PoseGraph graph;
  for (GraphEdge step : steps_of(all.odometry, all_scans(all.odometry))) {
    if (step.from < first) continue;
    step.from -= first;
    step.to -= first;
    graph.odometry.push_back(step);
  }
  std::vector<bool> is_held(joined.held.size() + 1, false);
  for (const std::vector<GraphEdge>& edges : {joined.edges, loops}) {
    for (GraphEdge edge : edges) {
      if (edge.to < first) continue;
      if (edge.from >= first) {
        edge.from -= first;
        edge.to -= first;
        graph.loops.push_back(edge);
        continue;
      }
      graph.priors.push_back({edge.to - first, all.odometry.T_map_lidar[edge.from] * edge.T_from_to,
                              edge.sigma_m, edge.sigma_rad});
      is_held[joined.piece[edge.to]] = true;
    }
  }
  for (std::uint32_t scan = first; scan < joined.piece.size(); ++scan) {
    if (is_held[joined.piece[scan]]) continue;
    is_held[joined.piece[scan]] = true;
    graph.held.push_back(scan - first);
  }
  return graph;
}

// Released scans this near are seen by the others too.
constexpr double kSeenTogether_m = 30.0;

// Scans to be adjusted: of those that are not released, and of those near them.
std::vector<std::uint32_t> keys_beside(const Followed& all, const std::vector<Pose>& poses) {
  std::vector<Eigen::Vector3d> later_m;
  for (std::size_t i = all.first; i < poses.size(); ++i) later_m.push_back(poses[i].translation());
  const PointGrid later(later_m);
  std::vector<std::uint32_t> keys;
  for (const std::uint32_t key : key_scans(all.odometry)) {
    if (key >= all.first || later.nearest(poses[key].translation(), kSeenTogether_m)) {
      keys.push_back(key);
    }
  }
  return keys;
}

// Whether five loops or more to released scans hold each run that was joined to them: then the pose
// graph lays them better than planes do ("Trajectories" in schemas/definitions.md).
bool are_held_by_loops(const Followed& all, const JoinedPieces& joined,
                       const std::vector<GraphEdge>& loops) {
  const auto later = joined.piece.begin() + static_cast<std::ptrdiff_t>(all.first);
  const std::uint32_t last_released_piece = *std::max_element(joined.piece.begin(), later);
  std::vector<std::uint32_t> loop_count(all.of_run.size());
  for (const GraphEdge& edge : loops) {
    if (edge.from < all.first) ++loop_count[all.odometry.piece[edge.to]];
  }
  for (std::size_t i = all.first; i < joined.piece.size(); ++i) {
    const bool is_joined = joined.piece[i] <= last_released_piece;
    if (is_joined && loop_count[all.odometry.piece[i]] < kTyingLoops) return false;
  }
  return true;
}

// All scans as loops or, where these are few, planes lay them that several saw; released ones do
// not move.
Result<Adjustment> adjusted(PassContext& ctx, const Drive& drive, const Followed& all,
                            std::vector<GraphEdge> edges, const std::vector<Pose>& poses,
                            bool stays) {
  const std::vector<std::uint32_t> keys = keys_beside(all, poses);
  PoseGraph graph = graph_of_keys({{}, std::move(edges), {}}, all.odometry, {}, keys);
  for (std::uint32_t i = 0; i < keys.size() && keys[i] < all.first; ++i) graph.held.push_back(i);
  const auto by_planes = stays ? weigh_by_planes : adjust_to_planes;
  return by_planes(ctx, drive, graph, poses, keys);
}

Result<Trajectory> lay_onto(PassContext& ctx, const EstimateTrajectoryOptions& options,
                            const Drive& drive, const Drive& seen, const Trajectory& released,
                            const Trajectory& own) {
  Followed all = followed(drive, released, own);
  SIGHTLINE_ASSIGN(const JoinedPieces joined,
                   join_pieces(ctx, seen, given_poses(drive, released, all), all.odometry,
                               {all.of_run, all.released_runs}));
  warn_of_pieces(ctx, seen, all.odometry, joined);
  std::vector<GraphEdge> loops;
  if (options.closes_loops) {
    SIGHTLINE_ASSIGN(loops, find_loops(ctx, seen, all.odometry, {all.first, all.first}));
  }
  const PoseGraph graph = graph_of_later(all, joined, loops);
  const std::vector<Pose> start(
      all.odometry.T_map_lidar.begin() + static_cast<std::ptrdiff_t>(all.first),
      all.odometry.T_map_lidar.end());
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, start));
  std::vector<Pose> poses(
      all.odometry.T_map_lidar.begin(),
      all.odometry.T_map_lidar.begin() + static_cast<std::ptrdiff_t>(all.first));
  poses.insert(poses.end(), solution.T_map_pose.begin(), solution.T_map_pose.end());
  const bool stays = are_held_by_loops(all, joined, loops);
  std::vector<GraphEdge> edges = joined.edges;
  edges.insert(edges.end(), loops.begin(), loops.end());
  SIGHTLINE_ASSIGN(const Adjustment adjustment,
                   adjusted(ctx, seen, all, std::move(edges), poses, stays));
  warn_of_contradictions(ctx, seen,
                         find_contradictions(all.odometry, loops, adjustment.T_map_lidar));
  Trajectory extended = released;
  extended.source = std::max(released.source, own.source);
  extended.odometry_edges += static_cast<std::uint32_t>(graph.odometry.size());
  extended.loop_edges += static_cast<std::uint32_t>(joined.edges.size() + loops.size());
  const Pose T_lidar_vehicle = drive.sensor.T_vehicle_lidar.inverse();
  for (std::size_t i = 0; i < own.poses.size(); ++i) {
    TrajectoryPose pose = own.poses[i];
    const ScanInfo& scan = drive.scans[all.first + i];
    pose.recording_index = scan.recording_index;
    pose.stamp_ns = scan.stamp_ns;
    const Pose& T_map_lidar = adjustment.T_map_lidar[all.first + i];
    pose.T_map_vehicle = T_map_lidar * T_lidar_vehicle;
    const Eigen::Vector3d arm_m = pose.T_map_vehicle.translation() - T_map_lidar.translation();
    pose.covariance = moved_by(arm_m, adjustment.covariance[all.first + i]);
    pose.piece = joined.piece[all.first + i];
    extended.poses.push_back(pose);
  }
  SIGHTLINE_ASSIGN(const std::vector<ScaleDifference> scales,
                   find_scale_differences(ctx, seen, extended, all.first));
  warn_of_scale_differences(ctx, seen, scales);
  return extended;
}

}  // namespace

Result<Drive> released_drive(PassContext& /*ctx*/, const NoOptions& /*options*/, const Drive& drive,
                             const ReleasedPoses& released) {
  SIGHTLINE_ASSIGN(const std::size_t count, count_released(drive, poses_of(drive, released)));
  if (count == drive.scans.size()) return drive;
  Drive shipped = stretch_of(drive, 0, count);
  shipped.later_parts.resize(drive.scans[count].part - 1);
  return shipped;
}

Result<Trajectory> released_trajectory(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                       const Drive& drive, const ReleasedPoses& released) {
  const std::vector<const TrajectoryPose*> poses = poses_of(drive, released);
  SIGHTLINE_ASSIGN(const std::size_t count, count_released(drive, poses));
  return shipped_trajectory(drive, released, poses, count);
}

Result<Trajectory> extend_released(PassContext& ctx, const EstimateTrajectoryOptions& options,
                                   const Drive& drive, const Drive& straight,
                                   const ReleasedPoses& released) {
  const std::vector<const TrajectoryPose*> poses = poses_of(drive, released);
  SIGHTLINE_ASSIGN(const std::size_t count, count_released(drive, poses));
  const Trajectory shipped = shipped_trajectory(drive, released, poses, count);
  SIGHTLINE_TRY(check_trajectory_of_drive(straight, shipped));
  if (count == drive.scans.size()) return shipped;
  SIGHTLINE_ASSIGN(const Trajectory own,
                   estimate_trajectory(ctx, options, parts_from(drive, count)));
  SIGHTLINE_ASSIGN(const Drive seen, straight_scans(ctx, drive, straight, own));
  return lay_onto(ctx, options, drive, seen, shipped, own);
}

Result<ReleasedPoses> release_poses(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                    const Drive& drive, const Trajectory& trajectory) {
  return release(drive, trajectory);
}

}  // namespace sightline
