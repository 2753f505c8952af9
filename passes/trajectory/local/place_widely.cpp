#include "passes/trajectory/local/place_widely.h"

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "formats/geometry.h"

namespace sightline {
namespace {

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
