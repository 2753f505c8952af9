#include "passes/trajectory/graph/plane_adjustment.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/trajectory/graph/normal_equations.h"
#include "passes/trajectory/graph/planes.h"
#include "passes/trajectory/local/local_match.h"

namespace sightline {
namespace {

constexpr double kTile_m = 64.0;
// Planes farther from the sensor are hit by few rays.
constexpr double kReach_m = 45.0;
constexpr int kMostRounds = 6;
// Shorter steps do not matter.
constexpr double kStopStep_m = 0.001;
constexpr double kStopStep_rad = 1e-5;
// Scans whose points are kept in memory.
constexpr std::size_t kCachedScans = 600;
// Tiles whose equations are made side by side.
constexpr std::size_t kTilesAtOnce = 8;
// Planes of one wall are not independent: so many of them weigh as much as an independent one.
constexpr double kDependentPlanes = 25.0;

using Points = std::vector<Eigen::Vector3f>;

Result<Points> near_points_m(const Drive& drive, std::uint32_t scan) {
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, scan, ThinnedFor::kMap));
  Points points_m;
  for (const Eigen::Vector3d& point_m : thinned.to_map_m) {
    if (point_m.norm() <= kReach_m) points_m.push_back(point_m.cast<float>());
  }
  return points_m;
}

// The latest scans that were used.
class ScanCache {
 public:
  ScanCache(const Drive& drive, const std::vector<std::uint32_t>& keys)
      : drive_(drive), keys_(keys), points_(keys.size()) {}

  Result<void> load(const std::set<std::uint32_t>& wanted, int threads) {
    std::vector<std::uint32_t> missing;
    for (const std::uint32_t key : wanted) {
      if (!points_[key]) missing.push_back(key);
    }
    SIGHTLINE_ASSIGN(std::vector<Points> read,
                     parallel_results<Points>(missing.size(), threads, [&](std::size_t i) {
                       return near_points_m(drive_, keys_[missing[i]]);
                     }));
    for (std::size_t i = 0; i < missing.size(); ++i) points_[missing[i]] = std::move(read[i]);
    order_.insert(order_.end(), missing.begin(), missing.end());
    for (std::size_t left = order_.size(); left > 0 && order_.size() > kCachedScans; --left) {
      const std::uint32_t oldest = order_.front();
      order_.pop_front();
      if (wanted.contains(oldest)) {
        order_.push_back(oldest);
      } else {
        points_[oldest].reset();
      }
    }
    return {};
  }
  [[nodiscard]] const Points& points_m(std::uint32_t key) const { return *points_[key]; }

 private:
  const Drive& drive_;
  const std::vector<std::uint32_t>& keys_;
  std::vector<std::optional<Points>> points_;
  std::deque<std::uint32_t> order_;
};

// The keys within reach of each tile.
std::map<TileKey, std::vector<std::uint32_t>> keys_of_tiles(const std::vector<Pose>& poses) {
  std::map<TileKey, std::vector<std::uint32_t>> tiles;
  const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(kReach_m);
  for (std::uint32_t key = 0; key < poses.size(); ++key) {
    const Eigen::Vector3d at_m = poses[key].translation();
    const TileKey low = tile_key(at_m - reach_m, kTile_m);
    const TileKey high = tile_key(at_m + reach_m, kTile_m);
    for (std::int32_t x = low.x; x <= high.x; ++x) {
      for (std::int32_t y = low.y; y <= high.y; ++y) tiles[{x, y}].push_back(key);
    }
  }
  return tiles;
}

void add_tile(const PlaneEquations& tile, const std::vector<std::uint32_t>& keys, Equations& all) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    all.gradient.segment<6>(6 * static_cast<Eigen::Index>(keys[i])) +=
        tile.gradient.segment<6>(row);
    for (std::size_t j = 0; j <= i; ++j) {
      const Matrix6d block = tile.hessian.block<6, 6>(row, static_cast<Eigen::Index>(6 * j));
      if (!block.isZero(0.0)) add_block(keys[i], keys[j], block, all);
    }
  }
}

// The terms of planes for poses that are not held.
Result<void> add_planes(PassContext& ctx, const std::vector<Pose>& poses,
                        const std::vector<bool>& is_held, ScanCache& cache, Equations& all) {
  const std::map<TileKey, std::vector<std::uint32_t>> tiles = keys_of_tiles(poses);
  std::vector<std::pair<TileKey, std::vector<std::uint32_t>>> list;
  for (const auto& [tile, keys] : tiles) {
    const bool is_sought =
        std::ranges::any_of(keys, [&](std::uint32_t key) { return !is_held[key]; });
    if (is_sought) list.emplace_back(tile, keys);
  }
  for (std::size_t first = 0; first < list.size(); first += kTilesAtOnce) {
    const std::size_t count = std::min(kTilesAtOnce, list.size() - first);
    std::set<std::uint32_t> wanted;
    for (std::size_t i = first; i < first + count; ++i) {
      wanted.insert(list[i].second.begin(), list[i].second.end());
    }
    SIGHTLINE_TRY(cache.load(wanted, ctx.threads));
    const std::vector<PlaneEquations> made =
        parallel_map<PlaneEquations>(count, ctx.threads, [&](std::size_t i) {
          const auto& [tile, keys] = list[first + i];
          std::vector<PlaneScan> scans;
          for (const std::uint32_t key : keys) {
            scans.push_back({key, poses[key], &cache.points_m(key), is_held[key]});
          }
          const Eigen::Vector2d low_m(tile.x * kTile_m, tile.y * kTile_m);
          return plane_equations(scans, low_m, low_m + Eigen::Vector2d(kTile_m, kTile_m));
        });
    for (std::size_t i = 0; i < count; ++i) add_tile(made[i], list[first + i].second, all);
  }
  return {};
}

// Scans between two keys are moved as these are, each in proportion to its nearness in number.
Adjustment spread(const std::vector<Pose>& start, const std::vector<std::uint32_t>& keys,
                  const std::vector<Pose>& moved_keys, const std::vector<Matrix6d>& covariance) {
  Adjustment all;
  std::size_t next = 0;
  for (std::uint32_t k = 0; k < start.size(); ++k) {
    while (next + 1 < keys.size() && keys[next] < k) ++next;
    const std::size_t before = keys[next] > k && next > 0 ? next - 1 : next;
    const Pose by_next = moved_keys[next] * start[keys[next]].inverse() * start[k];
    const Pose by_before = moved_keys[before] * start[keys[before]].inverse() * start[k];
    const double share = before == next ? 0.0
                                        : static_cast<double>(k - keys[before]) /
                                              static_cast<double>(keys[next] - keys[before]);
    all.T_map_lidar.push_back(interpolate(by_before, by_next, share));
    all.covariance.push_back((1.0 - share) * covariance[before] + share * covariance[next]);
  }
  return all;
}

Error no_solution() {
  return {ErrorCode::kTrajectoryLost, "the adjustment of planes has no solution", "",
          "pass estimate-trajectory"};
}

// Moves the poses; true where another round may move them by what matters.
bool moves_more(const Eigen::VectorXd& step, std::vector<Pose>& poses) {
  double longest_m = 0.0;
  double largest_rad = 0.0;
  for (std::size_t key = 0; key < poses.size(); ++key) {
    const Vector6d motion = step.segment<6>(static_cast<Eigen::Index>(6 * key));
    poses[key] = moved(poses[key], motion);
    longest_m = std::max(longest_m, motion.head<3>().norm());
    largest_rad = std::max(largest_rad, motion.tail<3>().norm());
  }
  return longest_m >= kStopStep_m || largest_rad >= kStopStep_rad;
}

// All scans, moved as their keys were, with the covariance by planes at these poses.
Result<Adjustment> weighed(const KeyGraph& keys, const std::vector<Pose>& start,
                           const std::vector<Pose>& poses, Equations& planes,
                           NormalSolver& solver) {
  for (auto& [key, block] : planes.blocks) block /= kDependentPlanes;
  add_graph(keys.graph, poses, planes);
  if (!solver.factor(planes)) return no_solution();
  return spread(start, keys.scans, poses, solver.inverse_blocks());
}

// The covariance of a point of the vehicle that is `arm_m` from the one it is known of, map axes:
// a small motion (dt, w) there is dt + w x arm here.
Matrix6d moved_by(const Eigen::Vector3d& arm_m, const Matrix6d& covariance) {
  Matrix6d by_motion = Matrix6d::Identity();
  by_motion.block<3, 3>(0, 3) << 0.0, arm_m.z(), -arm_m.y(), -arm_m.z(), 0.0, arm_m.x(), arm_m.y(),
      -arm_m.x(), 0.0;
  const Matrix6d there = by_motion * covariance * by_motion.transpose();
  return 0.5 * (there + there.transpose());
}

}  // namespace

Result<Adjustment> adjust_to_planes(PassContext& ctx, const Drive& drive, const KeyGraph& keys,
                                    const std::vector<Pose>& start, PlaneUse use) {
  std::vector<Pose> poses;
  for (const std::uint32_t scan : keys.scans) poses.push_back(start[scan]);
  std::vector<bool> is_held(poses.size(), false);
  for (const std::uint32_t key : keys.graph.held) is_held[key] = true;
  ScanCache cache(drive, keys.scans);
  NormalSolver solver;
  Equations planes;
  bool is_done = false;
  for (int round = 0; round < kMostRounds && !is_done; ++round) {
    planes = {{}, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * poses.size()))};
    SIGHTLINE_TRY(add_planes(ctx, poses, is_held, cache, planes));
    if (use == PlaneUse::kCovariance) break;
    const std::map<BlockKey, Matrix6d> of_planes_alone =
        blocks_below_graph(keys.graph, poses, planes);
    add_graph(keys.graph, poses, planes);
    if (!solver.factor(planes)) return no_solution();
    is_done = !moves_more(-solver.solve(planes.gradient), poses);
    for (const auto& [key, block] : of_planes_alone) planes.blocks[key] = block;
  }
  SIGHTLINE_ASSIGN(Adjustment adjustment, weighed(keys, start, poses, planes, solver));
  if (use == PlaneUse::kCovariance) adjustment.T_map_lidar = start;
  return adjustment;
}

std::vector<TrajectoryPose> vehicle_poses(const Drive& drive, const Adjustment& adjusted,
                                          const Odometry& odometry,
                                          const std::vector<std::uint32_t>& piece,
                                          std::size_t first) {
  std::vector<TrajectoryPose> poses;
  const Pose T_lidar_vehicle = drive.sensor.T_vehicle_lidar.inverse();
  for (std::size_t i = first; i < drive.scans.size(); ++i) {
    const Pose& T_map_lidar = adjusted.T_map_lidar[i];
    TrajectoryPose pose{drive.scans[i].recording_index, drive.scans[i].stamp_ns,
                        T_map_lidar * T_lidar_vehicle};
    const Eigen::Vector3d arm_m = pose.T_map_vehicle.translation() - T_map_lidar.translation();
    pose.covariance = moved_by(arm_m, adjusted.covariance[i]);
    pose.piece = piece[i];
    pose.overlap = odometry.overlap[i];
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace sightline
