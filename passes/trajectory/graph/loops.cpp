#include "passes/trajectory/graph/loops.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

// One scan in this much of the way looks for an earlier visit.
constexpr double kCandidateStep_m = 5.0;
// A return after less, within a piece, is what the local map of odometry saw already.
constexpr double kShortestLoop_m = 80.0;
// Visits of one place pass within this of each other, odometry's own drift aside.
constexpr double kSamePlace_m = 8.0;
constexpr double kDriftShare = 0.01;
constexpr double kLargestDrift_m = 4.0;
// The earlier visit's map: this much of the way before and after, one scan in so much.
constexpr double kVisitReach_m = 15.0;
constexpr double kVisitStep_m = 1.5;
// Stricter than odometry's, because a false loop bends the whole route.
constexpr double kLeastLikelihood = 1.8;
constexpr double kLeastScoredShare = 0.4;
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

// The nearest earlier visit of where scan `later` was.
std::optional<Candidate> candidate_of(const Odometry& odometry, const PointGrid& places,
                                      std::size_t later, std::size_t before) {
  const auto is_earlier_visit = [&](const NearPoint& point) {
    return point.index < std::min(later, before) &&
           (odometry.piece[later] != odometry.piece[point.index] ||
            odometry.driven_m[later] - odometry.driven_m[point.index] >= kShortestLoop_m) &&
           point.distance_m <= kSamePlace_m + drift_m(odometry, {point.index, later});
  };
  const std::optional<NearPoint> nearest = places.nearest(
      odometry.T_map_lidar[later].translation(), kSamePlace_m + kLargestDrift_m, is_earlier_visit);
  if (!nearest) return std::nullopt;
  return Candidate{nearest->index, later};
}

std::vector<Candidate> candidates(const Odometry& odometry, const LoopSearch& search) {
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
            candidate_of(odometry, places, k, search.before)) {
      found.push_back(*candidate);
    }
  }
  return found;
}

// The points of the earlier visit, in the map frame as odometry has it. Of its piece alone: the
// later one may begin right behind it, and no scan confirms itself.
Result<std::vector<Eigen::Vector3d>> visit_points_m(const Drive& drive, const Odometry& odometry,
                                                    std::size_t around) {
  std::vector<Eigen::Vector3d> points_m;
  double next_m = odometry.driven_m[around] - kVisitReach_m;
  for (std::size_t k = 0; k < odometry.T_map_lidar.size(); ++k) {
    if (odometry.driven_m[k] > odometry.driven_m[around] + kVisitReach_m) break;
    if (odometry.driven_m[k] < next_m || odometry.piece[k] != odometry.piece[around]) continue;
    next_m = odometry.driven_m[k] + kVisitStep_m;
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k));
    for (const Eigen::Vector3d& point_m : scan.to_map_m) {
      points_m.push_back(odometry.T_map_lidar[k] * point_m);
    }
  }
  return points_m;
}

// The edge of a candidate, or none where the scans do not match.
Result<std::optional<GraphEdge>> confirm(const Drive& drive, const Odometry& odometry,
                                         const Candidate& candidate) {
  SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> visit_m,
                   visit_points_m(drive, odometry, candidate.earlier));
  SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, candidate.later));
  const LocalGrids visit = local_grids(visit_m);
  const LocalMatch match =
      search_locally(visit, scan.to_match_m, odometry.T_map_lidar[candidate.later],
                     1.0 + drift_m(odometry, candidate));
  if (match.likelihood < kLeastLikelihood || match.scored_share < kLeastScoredShare) {
    return std::optional<GraphEdge>();
  }
  GraphEdge edge;
  edge.from = static_cast<std::uint32_t>(candidate.earlier);
  edge.to = static_cast<std::uint32_t>(candidate.later);
  edge.T_from_to =
      odometry.T_map_lidar[candidate.earlier].inverse() * sharpened(visit, scan.to_match_m, match);
  edge.sigma_m = kLoopSigma_m;
  edge.sigma_rad = kLoopSigma_rad;
  return std::optional<GraphEdge>(edge);
}

}  // namespace

Result<std::vector<GraphEdge>> find_loops(PassContext& ctx, const Drive& drive,
                                          const Odometry& odometry, const LoopSearch& search) {
  const std::vector<Candidate> list = candidates(odometry, search);
  std::vector<std::optional<GraphEdge>> edges(list.size());
  std::vector<std::optional<Error>> errors(list.size());
  parallel_for(list.size(), ctx.threads, [&](std::size_t i) {
    const Result<std::optional<GraphEdge>> edge = confirm(drive, odometry, list[i]);
    if (edge) {
      edges[i] = *edge;
    } else {
      errors[i] = edge.error();
    }
  });
  std::vector<GraphEdge> loops;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (errors[i]) return *errors[i];
    if (edges[i]) loops.push_back(*edges[i]);
  }
  return loops;
}

}  // namespace sightline
