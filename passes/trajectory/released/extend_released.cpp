#include "passes/trajectory/released/extend_released.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "formats/grid/point_grid.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/graph/check_poses.h"
#include "passes/trajectory/graph/plane_adjustment.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/graph/scan_graph.h"
#include "passes/trajectory/local/parts_of_drive.h"
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
      return Error{
          ErrorCode::kMismatchedInputs,
          fmt::format(
              "{} of its {} scans have released poses: the recording differs from the released one",
              known[part], all[part]),
          "", "drive " + name};
    }
    count += all[part];
    if (part > 0 && known[part - 1] == 0) {
      return Error{ErrorCode::kBadValue,
                   concat("it is released, but listed after drive ", drive.name_of_part(part - 1),
                          ", which is not. List new drives last"),
                   "", "drive " + name};
    }
  }
  if (count > 0) return count;
  return Error{ErrorCode::kMismatchedInputs,
               concat("none of the drives ", drive.names_of_parts(), " has released poses"), "",
               kPlace};
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
  std::vector<TrajectoryPose> shipped;
  for (std::size_t i = 0; i < count; ++i) {
    TrajectoryPose pose = trajectory.poses[static_cast<std::size_t>(poses[i] - first)];
    pose.recording_index = drive.scans[i].recording_index;
    pose.stamp_ns = drive.scans[i].stamp_ns;
    shipped.push_back(pose);
  }
  // A drive may have been left out: pieces are numbered anew in the order of their first scans.
  std::vector<std::uint32_t> pieces;
  for (TrajectoryPose& pose : shipped) {
    auto number = std::ranges::find(pieces, pose.piece);
    if (number == pieces.end()) number = pieces.insert(number, pose.piece);
    pose.piece = static_cast<std::uint32_t>(number - pieces.begin());
  }
  trajectory.poses = std::move(shipped);
  return trajectory;
}

// Released and estimated poses as the odometry of one drive.
struct Followed {
  Odometry odometry;  // its pieces are runs of scans of one known piece
  KnownPieces known;  // of the released scans, which come first
};

void follow(const Drive& drive, const Trajectory& trajectory, std::uint32_t first_piece,
            Followed& followed) {
  std::vector<std::uint32_t>& numbers = followed.known.number;
  const std::vector<Pose> T_map_lidar = sensor_poses(drive, trajectory);
  for (std::size_t i = 0; i < T_map_lidar.size(); ++i) {
    const std::uint32_t piece = first_piece + trajectory.poses[i].piece;
    const bool begins = !numbers.empty() && numbers.back() != piece;
    if (begins || numbers.empty()) numbers.push_back(piece);
    followed.odometry.append_known(T_map_lidar[i], begins, trajectory.poses[i].overlap);
  }
}

Followed followed(const Drive& drive, const Trajectory& released, const Trajectory& own) {
  Followed all;
  KnownPieces& known = all.known;
  follow(drive, released, 0, all);
  known.fixed = static_cast<std::uint32_t>(known.number.size());
  known.scans = released.poses.size();
  const std::uint32_t pieces = released.poses.back().piece + 1;
  follow(drive, own, std::max(pieces, std::ranges::max(known.number) + 1), all);
  return all;
}

// All scans as if each had been measured at once; `released`: those that were released.
Result<Drive> straight_scans(PassContext& ctx, const Drive& drive, const Drive& released,
                             const Trajectory& own) {
  PassContext without_warnings = quiet(ctx);  // undistort-scans gives them
  SIGHTLINE_ASSIGN(
      const Drive later,
      undistort_scans(without_warnings, {}, parts_from(drive, released.scans.size()), own));
  std::vector<Drive> parts = parts_of(released);
  for (Drive& part : parts_of(later)) parts.push_back(std::move(part));
  return joined_again(drive, parts);
}

// Given poses of the other scans and of the released ones, where both have some in one frame.
GivenPoses given_poses(const Drive& drive, const Trajectory& released, const Followed& all) {
  GivenPoses given(drive.scans.size());
  if (released.source == PoseSource::kEstimated) return given;  // in a frame of their own
  const auto is_given = [&](std::size_t i) { return drive.scans[i].T_world_vehicle.has_value(); };
  bool has_later = false;
  for (std::size_t i = all.known.scans; i < given.size(); ++i) has_later = has_later || is_given(i);
  // The trajectory of a drive with given poses is in their frame.
  for (std::size_t i = 0; has_later && i < given.size(); ++i) {
    if (i < all.known.scans || is_given(i)) given[i] = all.odometry.T_map_lidar[i];
  }
  return given;
}

// The scans that are not released, numbered from 0; edges to released ones are priors.
PoseGraph graph_of_later(const Followed& all, const Connections& connections) {
  const JoinedPieces& joined = connections.pieces;
  const auto first = static_cast<std::uint32_t>(all.known.scans);
  PoseGraph graph;
  for (GraphEdge step : steps_of(all.odometry, all_scans(all.odometry))) {
    if (step.from < first) continue;
    step.from -= first;
    step.to -= first;
    graph.odometry.push_back(step);
  }
  std::vector<bool> is_held(joined.held.size() + 1, false);
  for (GraphEdge edge : connections.edges()) {
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
  for (std::uint32_t scan = first; scan < joined.piece.size(); ++scan) {
    if (is_held[joined.piece[scan]]) continue;
    is_held[joined.piece[scan]] = true;
    graph.held.push_back(scan - first);
  }
  return graph;
}

// Scans to be adjusted: of those that are not released, and of those near them.
std::vector<std::uint32_t> keys_beside(const Followed& all, const std::vector<Pose>& poses) {
  constexpr double kCommonReach_m = 30.0;  // this near they have planes in common
  std::vector<Eigen::Vector3d> later_m;
  for (std::size_t i = all.known.scans; i < poses.size(); ++i)
    later_m.push_back(poses[i].translation());
  const PointGrid later(later_m);
  std::vector<std::uint32_t> keys;
  for (const std::uint32_t key : key_scans(all.odometry)) {
    if (key >= all.known.scans || later.nearest(poses[key].translation(), kCommonReach_m)) {
      keys.push_back(key);
    }
  }
  return keys;
}

// Whether five loops or more to released scans hold each run that was joined to them: then the pose
// graph is nearer to the truth than planes are ("Trajectories" in schemas/definitions.md).
bool are_held_by_loops(const Followed& all, const Connections& connections) {
  const std::vector<std::uint32_t>& piece = connections.pieces.piece;
  const std::size_t first = all.known.scans;
  const auto later = piece.begin() + static_cast<std::ptrdiff_t>(first);
  const std::uint32_t last_released_piece = *std::max_element(piece.begin(), later);
  std::vector<std::uint32_t> loop_count(all.known.number.size());
  for (const GraphEdge& edge : connections.loops) {
    if (edge.from < first) ++loop_count[all.odometry.piece[edge.to]];
  }
  for (std::size_t i = first; i < piece.size(); ++i) {
    const bool is_joined = piece[i] <= last_released_piece;
    if (is_joined && loop_count[all.odometry.piece[i]] < kConnectingLoops) return false;
  }
  return true;
}

// The graph of keys in which released poses are fixed.
KeyGraph key_graph(const Followed& all, const Connections& connections,
                   const std::vector<Pose>& poses) {
  const std::vector<std::uint32_t> keys = keys_beside(all, poses);
  KeyGraph of_keys = graph_of_keys({{}, connections.edges(), {}}, all.odometry, {}, keys);
  for (std::uint32_t i = 0; i < keys.size() && keys[i] < all.known.scans; ++i) {
    of_keys.graph.held.push_back(i);
  }
  return of_keys;
}

// The poses of all scans, those that are not released by the pose graph; adds its edges to
// `extended`.
Result<std::vector<Pose>> solve_later(const Followed& all, const Connections& connections,
                                      Trajectory& extended) {
  const PoseGraph graph = graph_of_later(all, connections);
  std::vector<Pose> poses = all.odometry.T_map_lidar;
  const auto later = poses.begin() + static_cast<std::ptrdiff_t>(all.known.scans);
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, {later, poses.end()}));
  std::ranges::copy(solution.T_map_pose, later);
  extended.odometry_edges += static_cast<std::uint32_t>(graph.odometry.size());
  extended.loop_edges += static_cast<std::uint32_t>(connections.edges().size());
  return poses;
}

// The aligned poses keep the unconstrained directions and the covariance of their own estimate: the
// released scans of the same place do not constrain it either.
void keep_unconstrained(const Trajectory& own, std::vector<TrajectoryPose>& aligned) {
  const bool has_any = std::ranges::any_of(
      own.poses, [](const TrajectoryPose& pose) { return pose.unconstrained.is_any(); });
  for (std::size_t i = 0; has_any && i < aligned.size(); ++i) {
    aligned[i].unconstrained = own.poses[i].unconstrained;
    aligned[i].covariance = own.poses[i].covariance;
  }
}

// The steps of estimate_trajectory.cpp for drives whose poses `own` are estimated already and are
// aligned to `released`, which do not move. `task`: all scans, undistorted.
Result<Trajectory> align_to(const EstimateTask& task, const Trajectory& released,
                            const Trajectory& own) {
  const auto& [ctx, options, drive] = task;
  Followed all = followed(drive, released, own);
  SIGHTLINE_ASSIGN(const Connections connections,
                   connect_scans(task, given_poses(drive, released, all), all.odometry, all.known));
  Trajectory extended = released;
  extended.source = std::max(released.source, own.source);
  SIGHTLINE_ASSIGN(const std::vector<Pose> poses, solve_later(all, connections, extended));
  const PlaneUse use =
      are_held_by_loops(all, connections) ? PlaneUse::kCovariance : PlaneUse::kPoses;
  SIGHTLINE_ASSIGN(const Adjustment adjusted,
                   adjust_to_planes(ctx, drive, key_graph(all, connections, poses), poses, use));
  warn_of_contradictions(ctx, drive,
                         find_contradictions(all.odometry, connections.loops, adjusted.T_map_lidar),
                         extended.notices);
  std::vector<TrajectoryPose> later =
      vehicle_poses(drive, adjusted, all.odometry, connections.pieces.piece, all.known.scans);
  keep_unconstrained(own, later);
  extended.notices.insert(extended.notices.end(), own.notices.begin(), own.notices.end());
  extended.poses.insert(extended.poses.end(), later.begin(), later.end());
  SIGHTLINE_TRY(warn_of_scale_differences(ctx, drive, extended, all.known.scans));
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
  SIGHTLINE_ASSIGN(const Drive all_straight, straight_scans(ctx, drive, straight, own));
  return align_to({ctx, options, all_straight}, shipped, own);
}

Result<ReleasedPoses> release_poses(PassContext& /*ctx*/, const NoOptions& /*options*/,
                                    const Drive& drive, const Trajectory& trajectory) {
  return release(drive, trajectory);
}

}  // namespace sightline
