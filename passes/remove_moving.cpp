#include "passes/remove_moving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "compiler/base/parallel.h"
#include "passes/remove_moving_voxels.h"
#include "passes/scan_selection.h"
#include "passes/trajectory_of_drive.h"

// A return says that something was there, and that nothing was between it and the sensor. A voxel
// that some scans hit and many others look through held something that moved.
//
// Carving by voxels alone eats what stands: a ray that grazes the ground, or passes a wall at a
// small angle, crosses many voxels whose points it does not touch; a thin pole fills a small part
// of its voxel. So a ray contradicts a voxel only when
// - it passes near the centre of the voxel's own points, not anywhere through the voxel;
// - it goes on well beyond it;
// - nothing that stands above the ground was hit in a neighbouring voxel by the same scan;
// - and, where the voxel is the lowest of its place, it ends clearly below it: ground stays.

namespace sightline {
namespace {

// OctoMap's sensor model: P(occupied) after a hit is 0.7, after a miss 0.4.
constexpr double kHitLogOdds = 0.8472978603872034;
constexpr double kMissLogOdds = -0.4054651081081644;
// A ray passes through a voxel's points when it comes this near their mean, in voxels.
constexpr double kTouch_voxels = 0.5;
// A ray says nothing of the last stretch before its end: range noise, and the slant of what it hit.
constexpr double kEndMargin_m = 0.5;
// Edge of the columns of which nine make the surroundings, in voxels: wide enough for the rings of
// a sparse sensor.
constexpr double kColumn_voxels = 3.0;
// Points up to here above the lowest of their surroundings are ground: kerbs and unevenness.
constexpr double kGroundThickness_m = 0.15;
// A voxel with no more evidence for standing than this goes with its neighbours if this many of the
// 26 moved: two hits and no miss.
constexpr double kWeakLogOdds = 2.0 * kHitLogOdds;
constexpr std::uint8_t kMovedAround = 3;
// A ray that ends this far below a ground voxel has gone through it.
constexpr double kBelowGround_m = 0.3;

struct Voxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::uint32_t point_count = 0;
  std::uint32_t hits = 0;  // scans with a return in it
  std::uint32_t last_scan = 0;
  bool is_ground = false;

  [[nodiscard]] Eigen::Vector3d mean_m() const { return sum_m / point_count; }
};

// The points of one scan within the list of all.
struct ScanPart {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // of the sensor
  std::size_t first = 0;
  std::size_t end = 0;
};

struct Returns {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<ScanPart> scans;
  std::uint64_t out_of_range_count = 0;
};

struct Scene {
  const Returns& returns;
  VoxelIndex index;
  std::vector<Voxel> voxels;
  std::vector<std::uint32_t> voxel_of_point;  // VoxelIndex::kNone beyond the octree
};

void append_scan(const Scan& scan, const SensorProfile& sensor, const Pose& T_map_lidar,
                 Returns& returns) {
  ScanPart part;
  part.origin_m = T_map_lidar.translation();
  part.first = returns.points_m.size();
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    const double range_m = point_m.norm();
    if (range_m < sensor.min_range_m || range_m > sensor.max_range_m) {
      ++returns.out_of_range_count;
    } else {
      returns.points_m.push_back(T_map_lidar * point_m);
    }
  }
  part.end = returns.points_m.size();
  returns.scans.push_back(part);
}

Result<Returns> read_returns(PassContext& ctx, const RemoveMovingOptions& options,
                             const Drive& drive, const Trajectory& trajectory) {
  const ScanSelection selection = scan_selection(options.scans);
  Returns returns;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (!is_selected(drive.scans[i], selection)) continue;
    const Result<Scan> scan = drive.store->read(i);
    if (!scan) return scan.error();
    const SensorProfile& sensor = drive.sensor_of(drive.scans[i]);
    const Pose T_map_lidar = trajectory.poses[i].T_map_vehicle * sensor.T_vehicle_lidar;
    append_scan(*scan, sensor, T_map_lidar, returns);
    ctx.progress(i + 1, 2 * drive.scans.size());
  }
  if (returns.scans.empty()) {
    return Error{ErrorCode::kDriveTooShort, "no scan is selected, expected at least one", "",
                 "pass remove-moving"};
  }
  if (returns.points_m.empty()) {
    return Error{ErrorCode::kEmptyMap,
                 "none of " + std::to_string(returns.out_of_range_count) +
                     " returns is within the sensor's range of " +
                     format_double(drive.sensor.min_range_m) + " to " +
                     format_double(drive.sensor.max_range_m) + " m",
                 "", "pass remove-moving"};
  }
  return returns;
}

Eigen::Vector3d middle_of(const std::vector<ScanPart>& scans) {
  Eigen::Vector3d low = scans.front().origin_m;
  Eigen::Vector3d high = low;
  for (const ScanPart& scan : scans) {
    low = low.cwiseMin(scan.origin_m);
    high = high.cwiseMax(scan.origin_m);
  }
  return 0.5 * (low + high);
}

void add_return(const Eigen::Vector3d& point_m, std::uint32_t scan, Scene& scene) {
  const std::uint32_t v = scene.index.insert(point_m);
  scene.voxel_of_point.push_back(v);
  if (v == VoxelIndex::kNone) return;
  if (v == scene.voxels.size()) scene.voxels.emplace_back();
  Voxel& voxel = scene.voxels[v];
  voxel.sum_m += point_m;
  ++voxel.point_count;
  if (voxel.hits == 0 || voxel.last_scan != scan) ++voxel.hits;
  voxel.last_scan = scan;
}

// Columns of the plane as one number, so that the neighbour of a column is a sum away.
std::int64_t column_number(std::int64_t x, std::int64_t y) {
  return x * (std::int64_t{1} << 32) + y;
}

// Ground is what lies within a hand's breadth of the lowest return of its surroundings.
void mark_ground(double voxel_m, std::vector<Voxel>& voxels) {
  const double column_m = kColumn_voxels * voxel_m;
  const auto index_of = [&](double x_m) {
    return static_cast<std::int64_t>(std::floor(x_m / column_m));
  };
  std::unordered_map<std::int64_t, double> lowest_m;
  for (const Voxel& voxel : voxels) {
    const Eigen::Vector3d mean_m = voxel.mean_m();
    const std::int64_t column = column_number(index_of(mean_m.x()), index_of(mean_m.y()));
    const auto [entry, is_new] = lowest_m.try_emplace(column, mean_m.z());
    if (!is_new) entry->second = std::min(entry->second, mean_m.z());
  }
  for (Voxel& voxel : voxels) {
    const Eigen::Vector3d mean_m = voxel.mean_m();
    double around_m = mean_m.z();
    for (int code = 0; code < 9; ++code) {
      const auto entry = lowest_m.find(
          column_number(index_of(mean_m.x()) + code % 3 - 1, index_of(mean_m.y()) + code / 3 - 1));
      if (entry != lowest_m.end()) around_m = std::min(around_m, entry->second);
    }
    voxel.is_ground = mean_m.z() < around_m + kGroundThickness_m;
  }
}

Scene build_scene(const RemoveMovingOptions& options, const Returns& returns) {
  Scene scene{returns, VoxelIndex(options.voxel_m, middle_of(returns.scans)), {}, {}};
  scene.voxel_of_point.reserve(returns.points_m.size());
  for (std::size_t k = 0; k < returns.scans.size(); ++k) {
    for (std::size_t i = returns.scans[k].first; i < returns.scans[k].end; ++i) {
      add_return(returns.points_m[i], static_cast<std::uint32_t>(k), scene);
    }
  }
  mark_ground(options.voxel_m, scene.voxels);
  return scene;
}

// The voxels with returns among the 26 around one.
std::vector<std::uint32_t> neighbours(const RemoveMovingOptions& options, const Scene& scene,
                                      const Voxel& voxel) {
  std::vector<std::uint32_t> found;
  for (int code = 0; code < 27; ++code) {
    if (code == 13) continue;  // itself
    const Eigen::Vector3d step(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
    const std::uint32_t v = scene.index.find(voxel.mean_m() + options.voxel_m * step);
    if (v != VoxelIndex::kNone) found.push_back(v);
  }
  return found;
}

// Looks through the scene with the rays of one scan after another and counts the misses.
class Carver {
 public:
  Carver(const RemoveMovingOptions& options, const Scene& scene)
      : options_(options),
        scene_(scene),
        walk_(scene.index),
        hit_by_(scene.voxels.size(), kNoScan),
        judged_by_(scene.voxels.size(), kNoScan),
        misses_(scene.voxels.size(), 0) {}

  void carve(std::uint32_t scan) {
    const ScanPart& part = scene_.returns.scans[scan];
    // One ray a voxel is enough: its neighbours say the same.
    rays_.clear();
    for (std::size_t i = part.first; i < part.end; ++i) {
      const std::uint32_t v = scene_.voxel_of_point[i];
      if (v == VoxelIndex::kNone || hit_by_[v] == scan) continue;
      hit_by_[v] = scan;
      rays_.push_back(i);
    }
    for (const std::size_t i : rays_) cast(part.origin_m, scene_.returns.points_m[i], scan);
  }
  [[nodiscard]] const std::vector<std::uint32_t>& misses() const { return misses_; }

 private:
  static constexpr std::uint32_t kNoScan = 0xffffffff;

  void cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& end_m, std::uint32_t scan) {
    const double range_m = (end_m - origin_m).norm();
    const double reach_m = std::min(range_m - kEndMargin_m, options_.carve_range_m);
    if (reach_m <= 0.0) return;
    const Eigen::Vector3d direction = (end_m - origin_m) / range_m;
    for (const std::uint32_t v : walk_.along(origin_m, origin_m + reach_m * direction)) {
      if (hit_by_[v] == scan || judged_by_[v] == scan) continue;
      const Voxel& voxel = scene_.voxels[v];
      const Eigen::Vector3d to_voxel_m = voxel.mean_m() - origin_m;
      const double along_m = to_voxel_m.dot(direction);
      const double beside_m = (to_voxel_m - along_m * direction).norm();
      if (along_m > reach_m || beside_m > kTouch_voxels * options_.voxel_m) continue;
      if (voxel.is_ground && end_m.z() > voxel.mean_m().z() - kBelowGround_m) continue;
      judged_by_[v] = scan;
      if (!has_hit_neighbour(voxel, scan)) ++misses_[v];
    }
  }

  // Whether this scan hit something above the ground in a voxel around.
  [[nodiscard]] bool has_hit_neighbour(const Voxel& voxel, std::uint32_t scan) const {
    return std::ranges::any_of(neighbours(options_, scene_, voxel), [&](std::uint32_t v) {
      return hit_by_[v] == scan && !scene_.voxels[v].is_ground;
    });
  }

  const RemoveMovingOptions& options_;
  const Scene& scene_;
  RayWalk walk_;
  std::vector<std::size_t> rays_;
  std::vector<std::uint32_t> hit_by_;     // the last scan with a return in the voxel
  std::vector<std::uint32_t> judged_by_;  // the last scan that had its say about the voxel
  std::vector<std::uint32_t> misses_;     // scans that looked through the voxel
};

// Each thread takes every n-th scan and counts for itself; whole numbers add up the same in any
// order.
std::vector<std::uint32_t> count_misses(PassContext& ctx, const RemoveMovingOptions& options,
                                        const Scene& scene) {
  const std::size_t scan_count = scene.returns.scans.size();
  const auto share_count = static_cast<std::size_t>(std::clamp(ctx.threads, 1, 16));
  const auto carve_share = [&](std::size_t share) {
    Carver carver(options, scene);
    for (std::size_t k = share; k < scan_count; k += share_count) {
      carver.carve(static_cast<std::uint32_t>(k));
      ctx.progress(scan_count + k + 1, 2 * scan_count);
    }
    return carver.misses();
  };
  const std::vector<std::vector<std::uint32_t>> shares =
      parallel_map<std::vector<std::uint32_t>>(share_count, ctx.threads, carve_share);
  std::vector<std::uint32_t> misses(scene.voxels.size(), 0);
  for (const std::vector<std::uint32_t>& share : shares) {
    for (std::size_t v = 0; v < misses.size(); ++v) misses[v] += share[v];
  }
  return misses;
}

double log_odds(const Voxel& voxel, std::uint32_t misses) {
  return voxel.hits * kHitLogOdds + misses * kMissLogOdds;
}

// One a voxel: 1 where it moved. A voxel that few rays tell of, such as the edge of a car seen
// once, goes with its neighbours.
std::vector<std::uint8_t> judge(const RemoveMovingOptions& options, const Scene& scene,
                                const std::vector<std::uint32_t>& misses) {
  std::vector<std::uint8_t> moved(scene.voxels.size(), 0);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    moved[v] = log_odds(scene.voxels[v], misses[v]) < 0.0 ? 1 : 0;
  }
  std::vector<std::uint8_t> moved_around(scene.voxels.size(), 0);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    if (moved[v] == 0) continue;
    for (const std::uint32_t near : neighbours(options, scene, scene.voxels[v]))
      ++moved_around[near];
  }
  std::vector<std::uint8_t> grown = moved;
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Voxel& voxel = scene.voxels[v];
    if (voxel.is_ground || moved_around[v] < kMovedAround) continue;
    if (log_odds(voxel, misses[v]) <= kWeakLogOdds) grown[v] = 1;
  }
  return grown;
}

void part_returns(PassContext& ctx, const RemoveMovingOptions& options, const Returns& returns,
                  SurfacePoints& surface) {
  const Scene scene = build_scene(options, returns);
  const std::vector<std::uint32_t> misses = count_misses(ctx, options, scene);
  const std::vector<std::uint8_t> moved = judge(options, scene, misses);
  std::uint64_t beyond_count = 0;
  for (std::size_t i = 0; i < returns.points_m.size(); ++i) {
    const std::uint32_t v = scene.voxel_of_point[i];
    if (v == VoxelIndex::kNone) ++beyond_count;
    const bool has_moved = v != VoxelIndex::kNone && moved[v] != 0;
    (has_moved ? surface.moving_m : surface.points_m).push_back(returns.points_m[i]);
  }
  surface.voxel_m = options.voxel_m;
  if (beyond_count > 0) {
    ctx.warn(std::to_string(beyond_count) +
             " returns lie beyond the reach of the octree and were kept without a check");
  }
}

}  // namespace

std::vector<OptionField> option_fields(RemoveMovingOptions& options) {
  return {
      flag("enabled", options.enabled, "take out what moved between scans"),
      number("voxel_m", options.voxel_m, "edge of the voxels that stand or move as a whole, m",
             0.05, 2.0),
      number("carve_range_m", options.carve_range_m,
             "rays look for what moved up to this distance from the sensor, m", 1.0, 200.0),
      scans_option(options.scans),
  };
}

Result<SurfacePoints> remove_moving(PassContext& ctx, const RemoveMovingOptions& options,
                                    const Drive& drive, const Trajectory& trajectory) {
  const Result<void> matches = check_trajectory_of_drive(drive, trajectory);
  if (!matches) return matches.error();
  Result<Returns> returns = read_returns(ctx, options, drive, trajectory);
  if (!returns) return returns.error();
  SurfacePoints surface;
  surface.frame = trajectory.frame;
  surface.out_of_range_count = returns->out_of_range_count;
  if (options.enabled) {
    part_returns(ctx, options, *returns, surface);
  } else {
    surface.points_m = std::move(returns->points_m);
  }
  return surface;
}

}  // namespace sightline
