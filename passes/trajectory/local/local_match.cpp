#include "passes/trajectory/local/local_match.h"

#include <algorithm>

#include "passes/matching/matcher.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

// Leaf of the points that are matched: several in each cell of a wall.
constexpr double kMatchLeaf_m = 0.5;
// Leaf of the points that make local maps, so dense that a single scan fills cells.
constexpr double kMapLeaf_m = 0.2;
// Farther returns are sparse, and the most distorted where the sensor turns.
constexpr double kFarthest_m = 70.0;
// Limits of a good and of a sure match. On streets the right pose has a likelihood of about 2 and a
// wrong one, similar only in part, 1 to 1.7; after a sparse first scan most points have no ND near.
constexpr double kLeastLikelihood = 1.2;
constexpr double kLeastScoredShare = 0.15;
constexpr double kLeastSureLikelihood = 1.8;
constexpr double kLeastSureShare = 0.4;
constexpr double kSearchStep_m = 1.0;
// Coarse matches that end this near each other lead to one fine match: its basin is many times
// wider.
constexpr double kSameEnd_m = 0.05;
constexpr double kSameTurn = 0.005;  // length of the difference of the rotations: 0.2 degrees
// A longer move by thin walls leads to another place.
constexpr double kMostSharpened_m = 0.2;
constexpr double kShortestStep_m = 5e-4;
constexpr double kShortestStep_rad = 1e-5;

}  // namespace

bool LocalMatch::is_better_than(const LocalMatch& other) const {
  const bool has_say = scored_share >= kLeastScoredShare;
  const bool other_has_say = other.scored_share >= kLeastScoredShare;
  return has_say == other_has_say ? likelihood > other.likelihood : has_say;
}

bool LocalMatch::is_good() const {
  return likelihood >= kLeastLikelihood && scored_share >= kLeastScoredShare;
}

bool LocalMatch::is_sure() const {
  return likelihood >= kLeastSureLikelihood && scored_share >= kLeastSureShare;
}

Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t index, ThinnedFor use) {
  SIGHTLINE_ASSIGN(const Scan scan, drive.store->read(index));
  const SensorProfile& sensor = drive.sensor_of(drive.scans[index]);
  const Pose T_first_sensor = drive.sensor.T_vehicle_lidar.inverse() * sensor.T_vehicle_lidar;
  std::vector<Eigen::Vector3d> within_m;
  within_m.reserve(scan.points_m.size());
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    const double range_m = point_m.norm();
    if (range_m >= sensor.min_range_m && range_m <= std::min(sensor.max_range_m, kFarthest_m)) {
      within_m.push_back(T_first_sensor * point_m);
    }
  }
  ThinnedScan thinned;
  if (use != ThinnedFor::kMap) thinned.to_match_m = voxel_subsample(within_m, kMatchLeaf_m);
  if (use != ThinnedFor::kMatch) thinned.to_map_m = voxel_subsample(within_m, kMapLeaf_m);
  return thinned;
}

Pose tidied(const Pose& pose) {
  Pose tidy = pose;
  tidy.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return tidy;
}

LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start) {
  return *LocalSearch(grids, points_m).match(T_map_start);
}

Pose sharpened(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
               const LocalMatch& found, LastStep last) {
  MatchOptions options;
  if (last == LastStep::kShortest) {
    options.stop_step_m = kShortestStep_m;
    options.stop_step_rad = kShortestStep_rad;
  }
  const MatchResult sharp = match(grids.sharp(), points_m, found.T_map_lidar, options);
  const double moved_m =
      (sharp.T_map_sensor.translation() - found.T_map_lidar.translation()).norm();
  return moved_m <= kMostSharpened_m ? tidied(sharp.T_map_sensor) : found.T_map_lidar;
}

LocalSearch::LocalSearch(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m)
    : grids_(grids), coarse_(make_scan_for_match(points_m)), fine_(make_scan_for_match(points_m)) {}

std::optional<LocalMatch> LocalSearch::match(const Pose& T_map_start) {
  const Pose T_map_end = sightline::match(grids_.coarse(), coarse_, T_map_start).T_map_sensor;
  const bool is_known = std::ranges::any_of(T_map_ends_, [&](const Pose& earlier) {
    return (earlier.translation() - T_map_end.translation()).norm() < kSameEnd_m &&
           (earlier.linear() - T_map_end.linear()).norm() < kSameTurn;
  });
  if (is_known) return std::nullopt;
  T_map_ends_.push_back(T_map_end);
  const MatchResult fine = sightline::match(grids_.fine(), fine_, T_map_end);
  LocalMatch result;
  result.T_map_lidar = tidied(fine.T_map_sensor);
  result.likelihood = fine.nearest_voxel_likelihood;
  const std::size_t count = fine_.points_m.size();
  result.scored_share = count == 0 ? 0.0 : fine.scored_points / static_cast<double>(count);
  return result;
}

std::vector<Pose> starts_around(const Pose& T_map_start, double reach_m) {
  std::vector<Pose> starts;
  const int steps = static_cast<int>(reach_m / kSearchStep_m);
  for (int i = -steps; i <= steps; ++i) {
    for (int j = -steps; j <= steps; ++j) {
      const Eigen::Vector3d offset_m(i * kSearchStep_m, j * kSearchStep_m, 0.0);
      if (offset_m.norm() > reach_m) continue;
      starts.push_back(T_map_start);
      starts.back().translation() += T_map_start.linear() * offset_m;
    }
  }
  return starts;
}

LocalMatch search_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                          const Pose& T_map_start, double reach_m) {
  LocalSearch search(grids, points_m);
  LocalMatch best;
  for (const Pose& start : starts_around(T_map_start, reach_m)) {
    const std::optional<LocalMatch> match = search.match(start);
    if (match && match->is_better_than(best)) best = *match;
  }
  return best;
}

}  // namespace sightline
