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
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/normal_equations.h"
#include "passes/trajectory/graph/normal_solver.h"
#include "passes/trajectory/graph/planes.h"

namespace sightline {
namespace {

constexpr double kTile_m = 64.0;
// Planes farther from the sensor are seen by few rays.
constexpr double kReach_m = 45.0;
constexpr int kMostRounds = 6;
// Another round would move nothing that matters.
constexpr double kStopStep_m = 0.001;
constexpr double kStopStep_rad = 1e-5;
// Scans whose points are kept at hand.
constexpr std::size_t kCachedScans = 600;
// Tiles whose equations are made side by side.
constexpr std::size_t kTilesAtOnce = 8;
// Planes of one wall are not independent: so many of them say as much as one would alone.
constexpr double kDependentPlanes = 25.0;

using Points = std::vector<Eigen::Vector3f>;

// The latest scans that were asked for.
class ScanCache {
 public:
  ScanCache(const Drive& drive, const std::vector<std::uint32_t>& keys)
      : drive_(drive), keys_(keys), points_(keys.size()) {}

  Result<void> load(const std::set<std::uint32_t>& wanted, int threads) {
    std::vector<std::uint32_t> missing;
    for (const std::uint32_t key : wanted) {
      if (!points_[key]) missing.push_back(key);
    }
    std::vector<std::optional<Error>> errors(missing.size());
    parallel_for(missing.size(), threads, [&](std::size_t i) {
      const Result<ThinnedScan> scan = read_thinned(drive_, keys_[missing[i]], ThinnedFor::kMap);
      if (!scan) {
        errors[i] = scan.error();
        return;
      }
      Points& points = points_[missing[i]].emplace();
      for (const Eigen::Vector3d& point_m : scan->to_map_m) {
        if (point_m.norm() <= kReach_m) points.push_back(point_m.cast<float>());
      }
    });
    for (const std::optional<Error>& error : errors) {
      if (error) return *error;
    }
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

// The keys that may see each tile.
std::map<TileKey, std::vector<std::uint32_t>> keys_of_tiles(const std::vector<Pose>& poses) {
  std::map<TileKey, std::vector<std::uint32_t>> tiles;
  const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(kReach_m);
  for (std::uint32_t key = 0; key < poses.size(); ++key) {
    const Eigen::Vector3d at_m = poses[key].translation();
    const TileKey low = tile_key(at_m - reach_m, kTile_m);
    const TileKey high = tile_key(at_m + reach_m, kTile_m);
    for (std::int32_t x = low.x; x <= high.x; ++x) {
      for (std::int32_t y = low.y; y <= high.y; ++y) {
        tiles[{x, y}].push_back(key);
      }
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

std::vector<bool> held_keys(const PoseGraph& graph, std::size_t key_count) {
  std::vector<bool> is_held(key_count, false);
  for (const std::uint32_t key : graph.held) is_held[key] = true;
  return is_held;
}

// What planes say of poses that are not held.
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
  return {ErrorCode::kTrajectoryLost, "the planes that scans share have no solution", "",
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

std::vector<Pose> poses_of_keys(const std::vector<Pose>& start,
                                const std::vector<std::uint32_t>& keys) {
  std::vector<Pose> poses;
  for (const std::uint32_t scan : keys) poses.push_back(start[scan]);
  return poses;
}

Equations no_equations(std::size_t pose_count) {
  return {{}, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * pose_count))};
}

// All scans, moved as their keys were, with what planes at these poses say of their covariance.
Result<Adjustment> weighed(const PoseGraph& graph, const std::vector<Pose>& start,
                           const std::vector<std::uint32_t>& keys, const std::vector<Pose>& poses,
                           Equations& planes, NormalSolver& solver) {
  for (auto& [key, block] : planes.blocks) block /= kDependentPlanes;
  add_graph(graph, poses, planes);
  if (!solver.factor(planes)) return no_solution();
  return spread(start, keys, poses, solver.inverse_blocks());
}

}  // namespace

Result<Adjustment> adjust_to_planes(PassContext& ctx, const Drive& drive, const PoseGraph& graph,
                                    const std::vector<Pose>& start,
                                    const std::vector<std::uint32_t>& keys) {
  std::vector<Pose> poses = poses_of_keys(start, keys);
  ScanCache cache(drive, keys);
  NormalSolver solver;
  Equations planes;
  for (int round = 0; round < kMostRounds; ++round) {
    planes = no_equations(poses.size());
    SIGHTLINE_TRY(add_planes(ctx, poses, held_keys(graph, keys.size()), cache, planes));
    const std::map<BlockKey, Matrix6d> of_planes_alone = blocks_below_graph(graph, poses, planes);
    add_graph(graph, poses, planes);
    if (!solver.factor(planes)) return no_solution();
    const bool is_done = !moves_more(-solver.solve(planes.gradient), poses);
    for (const auto& [key, block] : of_planes_alone) planes.blocks[key] = block;
    if (is_done) break;
  }
  return weighed(graph, start, keys, poses, planes, solver);
}

Result<Adjustment> weigh_by_planes(PassContext& ctx, const Drive& drive, const PoseGraph& graph,
                                   const std::vector<Pose>& start,
                                   const std::vector<std::uint32_t>& keys) {
  const std::vector<Pose> poses = poses_of_keys(start, keys);
  ScanCache cache(drive, keys);
  NormalSolver solver;
  Equations planes = no_equations(poses.size());
  SIGHTLINE_TRY(add_planes(ctx, poses, held_keys(graph, keys.size()), cache, planes));
  SIGHTLINE_ASSIGN(Adjustment adjustment, weighed(graph, start, keys, poses, planes, solver));
  adjustment.T_map_lidar = start;
  return adjustment;
}

Matrix6d moved_by(const Eigen::Vector3d& arm_m, const Matrix6d& covariance) {
  Matrix6d by_motion = Matrix6d::Identity();
  by_motion.block<3, 3>(0, 3) << 0.0, arm_m.z(), -arm_m.y(), -arm_m.z(), 0.0, arm_m.x(), arm_m.y(),
      -arm_m.x(), 0.0;
  const Matrix6d there = by_motion * covariance * by_motion.transpose();
  return 0.5 * (there + there.transpose());
}

}  // namespace sightline
