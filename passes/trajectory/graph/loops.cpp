#include "passes/trajectory/graph/loops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "formats/base/level.h"
#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"
#include "passes/trajectory/graph/height_errors.h"
#include "passes/trajectory/local/surface_between.h"

namespace sightline {
namespace {

// One scan in this much of the way is compared with an earlier visit.
constexpr double kCandidateStep_m = 5.0;
// A return after less way within a piece is in odometry's local map already.
constexpr double kShortestLoop_m = 80.0;
// Visits of one place pass within this of each other, odometry's own drift aside.
constexpr double kSamePlace_m = 8.0;
constexpr double kDriftShare = 0.01;
constexpr double kLargestDrift_m = 4.0;
// The earlier visit's map: scans of this much of the way before and after, one in so much.
constexpr double kVisitReach_m = 15.0;
constexpr double kVisitStep_m = 1.5;
// Candidates that are farther apart on either way, and every so many, are searched for anew.
constexpr double kMostBetween_m = 15.0;
constexpr std::size_t kLongestChain = 16;
// Around where a scan is expected.
constexpr double kNearReach_m = 1.0;
constexpr double kLoopSigma_m = 0.05;
constexpr double kLoopSigma_rad = 0.002;

struct Candidate {
  std::size_t earlier = 0;
  std::size_t later = 0;
};

double drift_m(const Odometry& odometry, const Candidate& c) {
  const double way_m = odometry.driven_m[c.later] - odometry.driven_m[c.earlier];
  return std::min(kDriftShare * way_m, kLargestDrift_m);
}

// What odometry knows of heights.
struct Heights {
  const Odometry& odometry;
  HeightErrors errors;

  [[nodiscard]] double above_m(const Candidate& c) const {
    return odometry.T_map_lidar[c.later].translation().z() -
           odometry.T_map_lidar[c.earlier].translation().z();
  }
  // Whether a height of the later scan may be off by so much. Pieces are joined by scans or by
  // given poses, whose heights have errors of metres.
  [[nodiscard]] bool may_be_off(const Candidate& c, double off_m) const {
    if (odometry.piece[c.later] != odometry.piece[c.earlier]) return true;
    return std::abs(off_m) < kLevelHeight_m + 3.0 * errors.sigma_m(c.earlier, c.later);
  }
};

// The nearest earlier visit of the place of scan `later`.
std::optional<Candidate> candidate_of(const Heights& heights, const PointGrid& places,
                                      std::size_t later, std::size_t before) {
  const Odometry& odometry = heights.odometry;
  const auto is_earlier_visit = [&](const NearPoint& point) {
    const Candidate c{point.index, later};
    return c.earlier < std::min(later, before) &&
           (odometry.piece[later] != odometry.piece[c.earlier] ||
            odometry.driven_m[later] - odometry.driven_m[c.earlier] >= kShortestLoop_m) &&
           point.distance_m <= kSamePlace_m + drift_m(odometry, c) &&
           heights.may_be_off(c, heights.above_m(c));
  };
  const std::optional<NearPoint> nearest = places.nearest(
      odometry.T_map_lidar[later].translation(), kSamePlace_m + kLargestDrift_m, is_earlier_visit);
  if (!nearest) return std::nullopt;
  return Candidate{nearest->index, later};
}

std::vector<Candidate> candidates(const Heights& heights, const LoopSearch& search) {
  const Odometry& odometry = heights.odometry;
  std::vector<Eigen::Vector3d> places_m;
  for (const Pose& T_map_lidar : odometry.T_map_lidar)
    places_m.push_back(T_map_lidar.translation());
  const PointGrid places(places_m);
  std::vector<Candidate> found;
  double next_m = 0.0;
  for (std::size_t k = search.from; k < odometry.T_map_lidar.size(); ++k) {
    if (odometry.driven_m[k] < next_m) continue;
    next_m = odometry.driven_m[k] + kCandidateStep_m;
    if (const std::optional<Candidate> candidate =
            candidate_of(heights, places, k, search.before)) {
      found.push_back(*candidate);
    }
  }
  return found;
}

// Candidates that follow each other on both ways, each kCandidateStep_m after the one before it.
using Chain = std::span<const Candidate>;

bool are_neighbours(const Odometry& odometry, const Candidate& a, const Candidate& b) {
  const auto is_near = [&](std::size_t i, std::size_t j) {
    return odometry.piece[i] == odometry.piece[j] &&
           std::abs(odometry.driven_m[i] - odometry.driven_m[j]) <= kMostBetween_m;
  };
  return is_near(a.earlier, b.earlier) && is_near(a.later, b.later);
}

std::vector<Chain> chains_of(const Odometry& odometry, std::span<const Candidate> list) {
  std::vector<Chain> chains;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= list.size(); ++i) {
    const bool goes_on = i < list.size() && i - begin < kLongestChain &&
                         are_neighbours(odometry, list[i - 1], list[i]);
    if (goes_on) continue;
    chains.push_back(list.subspan(begin, i - begin));
    begin = i;
  }
  return chains;
}

// The points of earlier visits along the way, in the map frame of odometry: scans that two visits
// share are read once.
class Visits {
 public:
  Visits(const Drive& drive, const Odometry& odometry) : drive_(drive), odometry_(odometry) {}

  // From one piece alone: the later one may begin right behind it, and no scan confirms itself.
  Result<std::vector<Eigen::Vector3d>> points_m(std::size_t around) {
    const auto driven_m = std::span(odometry_.driven_m);
    const double first_m = driven_m[around] - kVisitReach_m;
    const double last_m = driven_m[around] + kVisitReach_m;
    std::erase_if(kept_, [&](const auto& scan) {
      return driven_m[scan.first] < first_m || driven_m[scan.first] > last_m;
    });
    std::vector<Eigen::Vector3d> points_m;
    const auto begin = std::ranges::lower_bound(driven_m, first_m) - driven_m.begin();
    for (auto k = static_cast<std::size_t>(begin); k < driven_m.size(); ++k) {
      if (driven_m[k] > last_m) break;
      if (!takes_part(k) || odometry_.piece[k] != odometry_.piece[around]) continue;
      if (!kept_.contains(k)) {
        SIGHTLINE_ASSIGN(ThinnedScan scan, read_thinned(drive_, k, ThinnedFor::kMap));
        kept_[k] = std::move(scan.to_map_m);
      }
      for (const Eigen::Vector3d& point_m : kept_[k]) {
        points_m.push_back(odometry_.T_map_lidar[k] * point_m);
      }
    }
    return points_m;
  }

 private:
  // The first scan of each kVisitStep_m of the way.
  [[nodiscard]] bool takes_part(std::size_t k) const {
    const auto step_of = [&](std::size_t i) {
      return std::floor(odometry_.driven_m[i] / kVisitStep_m);
    };
    return k == 0 || odometry_.piece[k] != odometry_.piece[k - 1] || step_of(k) != step_of(k - 1);
  }

  const Drive& drive_;
  const Odometry& odometry_;
  std::map<std::size_t, std::vector<Eigen::Vector3d>> kept_;  // in the sensor's frame
};

// Whether the scans of a candidate are on two levels by the map around the lower one. That of the
// upper one has the ground between them, on one level too.
Result<bool> are_on_two_levels(const Drive& drive, const Heights& heights, const Candidate& c,
                               std::span<const Eigen::Vector3d> visit_m) {
  const Odometry& odometry = heights.odometry;
  const double above_m = heights.above_m(c);
  if (std::abs(above_m) < kLevelHeight_m) return false;
  const Eigen::Vector3d earlier_m = odometry.T_map_lidar[c.earlier].translation();
  const Eigen::Vector3d later_m = odometry.T_map_lidar[c.later].translation();
  if (above_m > 0.0) return is_surface_between(visit_m, earlier_m, later_m);
  SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> later_visit_m,
                   Visits(drive, odometry).points_m(c.later));
  return is_surface_between(later_visit_m, later_m, earlier_m);
}

// The edges of a chain, where the scans match. The first is searched for within the drift of
// odometry, later ones where the one before them was found or, where they are not there, as the
// first.
Result<std::vector<GraphEdge>> confirm(const Drive& drive, const Heights& heights, Chain chain) {
  const Odometry& odometry = heights.odometry;
  Visits visits(drive, odometry);
  std::vector<GraphEdge> edges;
  std::optional<Pose> T_found_odometry;  // of the later way, at the last edge
  for (const Candidate& candidate : chain) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> visit_m,
                     visits.points_m(candidate.earlier));
    SIGHTLINE_ASSIGN(const bool is_on_other_level,
                     are_on_two_levels(drive, heights, candidate, visit_m));
    if (is_on_other_level) continue;
    SIGHTLINE_ASSIGN(const ThinnedScan scan,
                     read_thinned(drive, candidate.later, ThinnedFor::kMatch));
    const LocalGrids visit = local_grids(visit_m);
    const Pose& T_map_later = odometry.T_map_lidar[candidate.later];
    LocalMatch match;
    if (T_found_odometry) {
      match = search_locally(visit, scan.to_match_m, *T_found_odometry * T_map_later, kNearReach_m);
    }
    if (!match.is_sure()) {
      match = search_locally(visit, scan.to_match_m, T_map_later,
                             kNearReach_m + drift_m(odometry, candidate));
    }
    const double moved_up_m = match.T_map_lidar.translation().z() - T_map_later.translation().z();
    if (!match.is_sure() || !heights.may_be_off(candidate, moved_up_m)) continue;
    T_found_odometry = tidied(match.T_map_lidar * T_map_later.inverse());
    edges.push_back({static_cast<std::uint32_t>(candidate.earlier),
                     static_cast<std::uint32_t>(candidate.later),
                     odometry.T_map_lidar[candidate.earlier].inverse() *
                         sharpened(visit, scan.to_match_m, match),
                     kLoopSigma_m, kLoopSigma_rad});
  }
  return edges;
}

}  // namespace

Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry,
                                          std::span<const GraphEdge> steps,
                                          const LoopSearch& search) {
  const Heights heights{odometry, HeightErrors(steps, odometry.T_map_lidar)};
  const std::vector<Candidate> list = candidates(heights, search);
  const std::vector<Chain> chains = chains_of(odometry, list);
  using Edges = std::vector<GraphEdge>;
  SIGHTLINE_ASSIGN(const std::vector<Edges> edges,
                   parallel_results<Edges>(chains.size(), ctx.threads, [&](std::size_t i) {
                     return confirm(drive, heights, chains[i]);
                   }));
  Edges loops;
  for (const Edges& of_chain : edges) loops.insert(loops.end(), of_chain.begin(), of_chain.end());
  return loops;
}

}  // namespace sightline
