#include "passes/trajectory/local/local_match.h"

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <utility>

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

constexpr double kElsewhere_m = 1.0;
constexpr double kElsewhere_rad = 5.0 * std::numbers::pi / 180.0;

// Of turned starts: the headings that are tried, with 300 points; how many headings of a place are
// matched; and by how much less overlap an earlier place is still preferred.
constexpr int kTurns = 33;
constexpr double kTurn_rad = 100.0 * std::numbers::pi / 180.0;
constexpr std::size_t kTurnedPoints = 300;
constexpr std::size_t kTurnsMatched = 2;
constexpr double kAlike = 0.03;

struct Candidate {
  LocalMatch match;
  double overlap = 0.0;
};

// The headings of a place from which most of the scan meets the map, 15 degrees and more apart.
std::vector<Pose> best_turns(const UprightMap& upright, const std::vector<Eigen::Vector3d>& few_m,
                             const Pose& T_map_place) {
  std::vector<std::pair<double, int>> turns;
  const auto turned = [&](int turn) {
    const double angle_rad = kTurn_rad * (2.0 * turn / (kTurns - 1) - 1.0);
    Pose pose = T_map_place;
    pose.linear() = rotation_matrix({Eigen::Vector3d::UnitZ(), angle_rad}) * T_map_place.linear();
    return pose;
  };
  for (int turn = 0; turn < kTurns; ++turn) {
    turns.emplace_back(-upright.overlap(few_m, turned(turn)).value_or(0.0), turn);
  }
  std::ranges::sort(turns);
  std::vector<int> taken;
  std::vector<Pose> best;
  for (const std::pair<double, int>& scored : turns) {
    const int turn = scored.second;
    const bool is_beside =
        std::ranges::any_of(taken, [&](int other) { return std::abs(other - turn) <= 2; });
    if (is_beside) continue;
    taken.push_back(turn);
    best.push_back(turned(turn));
    if (best.size() == kTurnsMatched) break;
  }
  return best;
}

// The ends of matches from these starts, each place once; only good matches.
std::vector<Candidate> ends_of(const std::vector<Pose>& starts, const LocalSurroundings& there,
                               const SoughtScan& scan) {
  LocalSearch search(there.grids, scan.to_match_m);
  std::vector<Candidate> ends;
  for (const Pose& T_map_start : starts) {
    const std::optional<LocalMatch> match = search.match(T_map_start);
    if (!match || !match->is_good()) continue;
    const std::optional<double> overlap = there.upright.overlap(scan.upright_m, match->T_map_lidar);
    if (overlap) ends.push_back({*match, *overlap});
  }
  return ends;
}

WidePlacement placement_of(const Candidate& best, const std::vector<Candidate>& candidates) {
  WidePlacement placement{best.match, best.overlap, 0.0};
  for (const Candidate& other : candidates) {
    if (!are_elsewhere(other.match.T_map_lidar, best.match.T_map_lidar)) continue;
    placement.overlap_elsewhere = std::max(placement.overlap_elsewhere, other.overlap);
  }
  return placement;
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
  const std::size_t count = fine_.points_m.size();
  return LocalMatch{tidied(fine.T_map_sensor), fine.nearest_voxel_likelihood,
                    count == 0 ? 0.0 : fine.scored_points / static_cast<double>(count)};
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

bool are_elsewhere(const Pose& a, const Pose& b) {
  const Pose between = a.inverse() * b;
  return between.translation().norm() > kElsewhere_m ||
         rotation_angle_rad(between.linear()) > kElsewhere_rad;
}

std::optional<WidePlacement> place_widely(const LocalSurroundings& there, const SoughtScan& scan,
                                          const Pose& T_map_around, const WideSearch& options) {
  std::vector<Pose> starts;
  for (const WiderStart& start :
       wider_starts(there.upright.points_m(), scan.upright_m, T_map_around, options)) {
    starts.push_back(start.T_map_lidar);
  }
  const std::vector<Candidate> candidates = ends_of(starts, there, scan);
  if (candidates.empty()) return std::nullopt;
  return placement_of(*std::ranges::max_element(candidates, {}, &Candidate::overlap), candidates);
}

std::optional<WidePlacement> place_turned(const LocalSurroundings& there, const SoughtScan& scan,
                                          const std::vector<Pose>& T_map_places) {
  std::vector<Eigen::Vector3d> few_m;
  const std::size_t step = scan.upright_m.size() / kTurnedPoints + 1;
  for (std::size_t i = 0; i < scan.upright_m.size(); i += step) few_m.push_back(scan.upright_m[i]);
  std::vector<Pose> starts;
  for (const Pose& T_map_place : T_map_places) {
    const std::vector<Pose> turns = best_turns(there.upright, few_m, T_map_place);
    starts.insert(starts.end(), turns.begin(), turns.end());
  }
  const std::vector<Candidate> candidates = ends_of(starts, there, scan);
  if (candidates.empty()) return std::nullopt;
  const double most = std::ranges::max(candidates, {}, &Candidate::overlap).overlap;
  const auto best = std::ranges::find_if(
      candidates, [&](const Candidate& one) { return one.overlap >= most - kAlike; });
  return placement_of(*best, candidates);
}

}  // namespace sightline
