#include "passes/trajectory/odometry.h"

#include <algorithm>
#include <array>
#include <deque>
#include <string>
#include <utility>

#include "formats/rotation.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/matcher.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

// Leaf of the points that are matched: several in each cell of a wall.
constexpr double kMatchLeaf_m = 0.5;
// Leaf of the points that make local maps, so dense that a single scan fills cells.
constexpr double kMapLeaf_m = 0.2;
// Farther returns are sparse, and where the sensor turns, the least rigid.
constexpr double kFarthest_m = 70.0;
// Below these a match is not believed. On streets the right pose has a likelihood of about 2 and a
// wrong one, which looks alike only in part, 1 to 1.7; a sparse first scan leaves most points
// without an ND near.
constexpr double kLeastLikelihood = 1.2;
constexpr double kLeastScoredShare = 0.15;
// How far from where constant velocity leads a scan may be looked for: at the start, when nothing
// is known of the speed, and where matching has failed.
constexpr double kSearchReach_m = 3.0;
constexpr double kSearchStep_m = 1.0;

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
  if (k >= 2) {
    starts.push_back(T_map_lidar[k - 1] * T_map_lidar[k - 2].inverse() * T_map_lidar[k - 1]);
  } else {
    starts.push_back(T_map_lidar[k - 1]);
  }
  if (given[k - 1] && given[k]) {
    starts.push_back(T_map_lidar[k - 1] * given[k - 1]->inverse() * *given[k]);
  }
  for (Pose& start : starts) start = tidied(start);
  return starts;
}

// How well the latest scans matched: where one does much worse, it was looked for in a wrong place.
struct RunningAverage {
  double likelihood = 0.0;
  double scored_share = 0.0;

  void add(const LocalMatch& match) {
    if (likelihood == 0.0) *this = {match.likelihood, match.scored_share};
    likelihood += kNewShare * (match.likelihood - likelihood);
    scored_share += kNewShare * (match.scored_share - scored_share);
  }
  [[nodiscard]] bool is_met_by(const LocalMatch& match) const {
    return match.likelihood >= kUsual * likelihood && match.scored_share >= kUsual * scored_share;
  }

  static constexpr double kNewShare = 0.1;
  static constexpr double kUsual = 0.85;
};

// Where a vehicle may be that begins or ends a turn, or brakes, harder than constant velocity has
// it.
std::vector<Pose> bolder(const Pose& T_map_before, const Pose& T_map_start) {
  std::vector<Pose> starts;
  const Pose step = T_map_before.inverse() * T_map_start;
  for (const double turn_rad : {-0.12, -0.06, 0.06, 0.12}) {
    Pose start = T_map_start;
    start.linear() = T_map_start.linear() * rotation_matrix({Eigen::Vector3d::UnitZ(), turn_rad});
    starts.push_back(start);
  }
  for (const double share : {0.0, 0.5, 1.5}) {
    Pose part = step;
    part.translation() *= share;
    starts.push_back(T_map_before * part);
  }
  return starts;
}

LocalMatch best_of(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                   const std::vector<Pose>& starts, LocalMatch best) {
  for (const Pose& start : starts) {
    const LocalMatch match = match_locally(grids, points_m, start);
    if (match.is_better_than(best)) best = match;
  }
  return best;
}

LocalMatch follow(const LocalMap& map, const std::vector<Eigen::Vector3d>& points_m,
                  const std::vector<Pose>& starts, const Pose& T_map_before,
                  const RunningAverage& average) {
  LocalMatch best = best_of(map.grids(), points_m, starts, {});
  if (!average.is_met_by(best)) {
    best = best_of(map.grids(), points_m, bolder(T_map_before, starts.front()), best);
  }
  const bool is_first = average.likelihood == 0.0;
  if (is_first || !best.is_good()) {
    for (const Pose& start : starts) {
      const LocalMatch match = search_locally(map.grids(), points_m, start, kSearchReach_m);
      if (match.is_better_than(best)) best = match;
    }
  }
  return best;
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

Result<ThinnedScan> read_thinned(const Drive& drive, std::size_t index) {
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
  return ThinnedScan{voxel_subsample(within_m, kMatchLeaf_m),
                     voxel_subsample(within_m, kMapLeaf_m)};
}

LocalMatch match_locally(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                         const Pose& T_map_start) {
  MatchOptions options;
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
  RunningAverage average;
  for (std::size_t k = 0; k < count; ++k) {
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k));
    Pose T_map_lidar = given[0].value_or(drive.sensor.T_vehicle_lidar);
    bool is_matched = true;
    double step_m = 0.0;
    if (k > 0) {
      const std::vector<Pose> starts = predictions(odometry.T_map_lidar, given, k);
      const LocalMatch match =
          follow(map, scan.to_match_m, starts, odometry.T_map_lidar.back(), average);
      is_matched = match.is_good();
      if (is_matched) average.add(match);
      const bool is_given = given[k - 1] && given[k];
      if (!is_matched && !is_given) return lost(drive, k, match);
      T_map_lidar = is_matched ? match.T_map_lidar : starts.back();
      step_m = (T_map_lidar.translation() - odometry.T_map_lidar.back().translation()).norm();
    }
    odometry.T_map_lidar.push_back(T_map_lidar);
    odometry.is_matched.push_back(is_matched);
    odometry.driven_m.push_back(k == 0 ? 0.0 : odometry.driven_m.back() + step_m);
    if (k == 0 || map.wants(T_map_lidar)) {
      map.add(scan.to_map_m, T_map_lidar, odometry.driven_m.back());
    }
    ctx.progress(k + 1, count);
  }
  return odometry;
}

}  // namespace sightline
