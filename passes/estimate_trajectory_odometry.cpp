#include "passes/estimate_trajectory_odometry.h"

#include <algorithm>
#include <array>
#include <deque>
#include <string>
#include <utility>

#include "passes/build_ndt.h"
#include "passes/matching/matcher.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

// Leaf of the points that are matched: several in each cell of a wall.
constexpr double kMatchLeaf_m = 0.5;
// Leaf of the points that make local maps, so dense that a single scan fills cells.
constexpr double kMapLeaf_m = 0.2;
// Fewer than a map needs, because a local one begins with a single scan.
constexpr int kLeastPoints = 6;
// Farther returns are sparse, and where the sensor turns, the least rigid.
constexpr double kFarthest_m = 70.0;
constexpr double kCoarseCell_m = 2.0;
constexpr double kFineCell_m = 1.0;
// Standard deviations across and along the surface of a cell.
constexpr double kThinnest_m = 0.05;
constexpr double kAlong_m = 2.0;
// A scan joins the local map when the vehicle has come this far since the last one that did.
constexpr double kKeyframeStep_m = 1.0;
constexpr double kKeyframeTurn_rad = 0.1;
// Below these a match is not believed. On streets the right pose has a likelihood of about 2 and a
// wrong one, which looks alike only in part, 1 to 1.7; a sparse first scan leaves most points
// without an ND near.
constexpr double kLeastLikelihood = 1.2;
constexpr double kLeastScoredShare = 0.15;
// How far from where constant velocity leads a scan may be looked for: at the start, when nothing
// is known of the speed, and where matching has failed.
constexpr double kSearchReach_m = 3.0;
constexpr double kSearchStep_m = 1.0;

// What an ND says of a point beside it: as much as its cell's surface holds it, and no more. A wall
// holds a point in its normal; along the wall the points of a cell end where the field of view did,
// not where the wall does. Taken for shape, that end would tilt each scan a little, always the same
// way.
Eigen::Matrix3d surface_information_per_m2(const Nd& nd) {
  Eigen::Vector3d variance_m2 = nd.eigenvalues_m2.cwiseMax(kThinnest_m * kThinnest_m);
  const double along_m2 = kAlong_m * kAlong_m;
  const int dimensions = dimension_class(nd);
  if (dimensions == 2) {
    variance_m2[0] = variance_m2[1] = along_m2;
  } else if (dimensions == 1) {
    const bool is_upright = std::abs(nd.eigenvectors(2, 0)) > 0.7;
    variance_m2[0] = along_m2;
    // A ring of the sensor is a line as well, but no edge.
    if (!is_upright) variance_m2[1] = variance_m2[2] = along_m2;
  }
  return nd.eigenvectors * variance_m2.cwiseInverse().asDiagonal() * nd.eigenvectors.transpose();
}

MatchGrid surface_grid(const std::vector<Eigen::Vector3d>& points_m, double cell_m, int threads) {
  BuildNdtOptions options;
  options.cell_m = cell_m;
  options.min_points = kLeastPoints;
  const NdtMap map = ndt_from_points(points_m, MapFrame{}, options, threads);
  MatchGrid grid = make_match_grid(map);
  std::size_t listed = 0;  // the grid lists the map's NDs in order, but may leave some out
  for (const Nd& nd : map.nds) {
    if (listed == grid.nds.size() || grid.nds[listed].mean_m != nd.mean_m) continue;
    grid.nds[listed++].information_per_m2 = surface_information_per_m2(nd);
  }
  return grid;
}

// The latest key scans, in the map frame.
class LocalMap {
 public:
  explicit LocalMap(double reach_m) : reach_m_(reach_m) {}

  void add(const std::vector<Eigen::Vector3d>& points_m, const Pose& T_map_lidar, double driven_m,
           int threads) {
    KeyScan& key = scans_.emplace_back();
    key.driven_m = driven_m;
    key.points_m.reserve(points_m.size());
    for (const Eigen::Vector3d& point_m : points_m) key.points_m.push_back(T_map_lidar * point_m);
    while (scans_.front().driven_m < driven_m - reach_m_) scans_.pop_front();
    std::vector<Eigen::Vector3d> all_m;
    for (const KeyScan& scan : scans_) {
      all_m.insert(all_m.end(), scan.points_m.begin(), scan.points_m.end());
    }
    grids_ = local_grids(all_m, threads);
    T_map_last_ = T_map_lidar;
  }
  [[nodiscard]] bool wants(const Pose& T_map_lidar) const {
    const Pose step = T_map_last_.inverse() * T_map_lidar;
    return step.translation().norm() >= kKeyframeStep_m ||
           Eigen::AngleAxisd(step.linear()).angle() >= kKeyframeTurn_rad;
  }
  [[nodiscard]] const LocalGrids& grids() const { return grids_; }

 private:
  struct KeyScan {
    double driven_m = 0.0;
    std::vector<Eigen::Vector3d> points_m;
  };
  double reach_m_;
  std::deque<KeyScan> scans_;
  LocalGrids grids_;
  Pose T_map_last_ = Pose::Identity();
};

// Rotations that are multiplied for kilometres drift from being rotations.
Pose tidied(const Pose& pose) {
  Pose tidy = pose;
  tidy.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return tidy;
}

// Where scan k may be, by what is known of its motion; the likeliest first.
std::vector<Pose> predictions(const std::vector<Pose>& T_map_lidar,
                              const std::vector<std::optional<Pose>>& given, std::size_t k) {
  std::vector<Pose> starts;
  if (k >= 2)
    starts.push_back(T_map_lidar[k - 1] * T_map_lidar[k - 2].inverse() * T_map_lidar[k - 1]);
  if (given[k - 1] && given[k]) {
    starts.push_back(T_map_lidar[k - 1] * given[k - 1]->inverse() * *given[k]);
  }
  if (starts.empty()) starts.push_back(T_map_lidar[k - 1]);
  for (Pose& start : starts) start = tidied(start);
  return starts;
}

LocalMatch follow(const LocalMap& map, const std::vector<Eigen::Vector3d>& points_m,
                  const std::vector<Pose>& starts, bool is_first) {
  LocalMatch best;
  for (const Pose& start : starts) {
    const LocalMatch match = match_locally(map.grids(), points_m, start);
    if (match.is_better_than(best)) best = match;
  }
  if (is_first || !best.is_good()) {
    for (const Pose& start : starts) {
      const LocalMatch match = search_locally(map.grids(), points_m, start, kSearchReach_m);
      if (match.is_better_than(best)) best = match;
    }
  }
  return best;
}

Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t k) {
  const Result<Scan> scan = drive.store->read(k);
  if (!scan) return scan.error();
  return thinned_scan(*scan, drive.sensor);
}

Error lost(const Drive& drive, std::size_t k, const LocalMatch& match) {
  return {ErrorCode::kTrajectoryLost,
          "the scan does not match what was seen before it (likelihood " +
              format_double(match.likelihood) + ", expected " + format_double(kLeastLikelihood) +
              "; " + format_double(match.scored_share) +
              " of its points near the local map) and no given pose helps",
          drive.scans[k].source, "scan " + std::to_string(drive.scans[k].recording_index)};
}

}  // namespace

bool LocalMatch::is_better_than(const LocalMatch& other) const {
  const bool has_say = scored_share >= kLeastScoredShare;
  const bool other_has_say = other.scored_share >= kLeastScoredShare;
  return has_say == other_has_say ? likelihood > other.likelihood : has_say;
}

bool LocalMatch::is_good() const {
  return likelihood >= kLeastLikelihood && scored_share >= kLeastScoredShare;
}

ThinnedScan thinned_scan(const Scan& scan, const SensorProfile& sensor) {
  std::vector<Eigen::Vector3d> within_m;
  within_m.reserve(scan.points_m.size());
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    const double range_m = point_m.norm();
    if (range_m >= sensor.min_range_m && range_m <= std::min(sensor.max_range_m, kFarthest_m)) {
      within_m.push_back(point_m);
    }
  }
  return {voxel_subsample(within_m, kMatchLeaf_m), voxel_subsample(within_m, kMapLeaf_m)};
}

LocalGrids local_grids(const std::vector<Eigen::Vector3d>& points_m, int threads) {
  return {surface_grid(points_m, kCoarseCell_m, threads),
          surface_grid(points_m, kFineCell_m, threads)};
}

LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start) {
  MatchOptions options;
  options.kernel = MatchKernel::kExact;  // the others do not see the grids' own information
  const MatchResult coarse = match(grids.coarse, points_m, T_map_start, options);
  const MatchResult fine = match(grids.fine, points_m, coarse.T_map_sensor, options);
  LocalMatch result;
  result.T_map_lidar = tidied(fine.T_map_sensor);
  result.likelihood = fine.nearest_voxel_likelihood;
  result.scored_share =
      points_m.empty() ? 0.0 : fine.scored_points / static_cast<double>(points_m.size());
  return result;
}

LocalMatch search_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                          const Pose& T_map_start, double reach_m) {
  LocalMatch best;
  const int steps = static_cast<int>(reach_m / kSearchStep_m);
  for (int i = -steps; i <= steps; ++i) {
    for (int j = -steps; j <= steps; ++j) {
      const Eigen::Vector3d offset_m(i * kSearchStep_m, j * kSearchStep_m, 0.0);
      if (offset_m.norm() > reach_m) continue;
      Pose start = T_map_start;
      start.translation() += T_map_start.linear() * offset_m;
      const LocalMatch match = match_locally(grids, points_m, start);
      if (match.is_better_than(best)) best = match;
    }
  }
  return best;
}

Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given) {
  const std::size_t count = drive.scans.size();
  if (count < 2) {
    return Error{ErrorCode::kDriveTooShort,
                 "found " + std::to_string(count) + " scans, expected at least 2 to match", "",
                 "drive " + drive.name};
  }
  Odometry odometry;
  LocalMap map(local_map_m);
  for (std::size_t k = 0; k < count; ++k) {
    const Result<ThinnedScan> scan = read_thinned(drive, k);
    if (!scan) return scan.error();
    Pose T_map_lidar = given[0].value_or(drive.sensor.T_vehicle_lidar);
    bool is_matched = true;
    double step_m = 0.0;
    if (k > 0) {
      const std::vector<Pose> starts = predictions(odometry.T_map_lidar, given, k);
      const LocalMatch match = follow(map, scan->to_match_m, starts, k == 1);
      is_matched = match.is_good();

      const bool is_given = given[k - 1] && given[k];
      if (!is_matched && !is_given) return lost(drive, k, match);
      T_map_lidar = is_matched ? match.T_map_lidar : starts.back();
      step_m = (T_map_lidar.translation() - odometry.T_map_lidar.back().translation()).norm();
    }
    odometry.T_map_lidar.push_back(T_map_lidar);
    odometry.is_matched.push_back(is_matched);
    odometry.driven_m.push_back(k == 0 ? 0.0 : odometry.driven_m.back() + step_m);
    if (k == 0 || map.wants(T_map_lidar)) {
      map.add(scan->to_map_m, T_map_lidar, odometry.driven_m.back(), ctx.threads);
    }
    ctx.progress(k + 1, count);
  }
  return odometry;
}

}  // namespace sightline
