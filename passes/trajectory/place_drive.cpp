#include "passes/trajectory/place_drive.h"

#include <algorithm>
#include <functional>
#include <numbers>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/geometry.h"
#include "passes/matching/matcher.h"
#include "passes/trajectory/graph/check_poses.h"
#include "passes/trajectory/local/local_match.h"

namespace sightline {
namespace {

// So many scans, evenly over the drive, are searched for everywhere: about this many points of each
// select the places where all of them are matched.
constexpr std::size_t kQueries = 8;
constexpr std::size_t kFewPoints = 200;
constexpr std::size_t kWorthAMatch = 16;
// A good match has at least this likelihood, and so many points with an ND near. In its place a
// scan of a generated town scores about 2.5, elsewhere 1 to 1.7.
constexpr double kLeastLikelihood = 1.8;
constexpr double kLeastScoredShare = 0.4;
// A placement that another scan confirms moves it no farther than this.
constexpr double kConfirms_m = 1.0;
constexpr double kConfirms_rad = 0.05;

struct QueryScan {
  std::size_t scan = 0;
  Pose T_own_lidar = Pose::Identity();
  std::vector<Eigen::Vector3d> points_m;
};

Result<std::vector<QueryScan>> make_queries(const Drive& drive, const ScanRange& piece,
                                            const std::vector<Pose>& T_own_lidar) {
  std::vector<QueryScan> queries;
  for (const std::size_t i : evenly(piece.size(), kQueries)) {
    const std::size_t k = piece.begin + i;
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k, ThinnedFor::kMatch));
    queries.push_back({k, T_own_lidar[k], scan.to_match_m});
  }
  return queries;
}

// Where a few points of a scan match best, the best first. Starts that end at one place count once.
std::vector<Pose> likely_places(const MatchGrid& grid, const QueryScan& query,
                                const std::vector<Pose>& places) {
  const std::vector<Eigen::Vector3d>& points_m = query.points_m;
  const std::size_t stride = std::max<std::size_t>(1, points_m.size() / kFewPoints);
  std::vector<Eigen::Vector3d> few_m;
  for (std::size_t i = 0; i < points_m.size(); i += stride) few_m.push_back(points_m[i]);
  std::vector<MapMatch> found;
  for (const Pose& place : places) found.push_back(match_to_map(grid, few_m, place));
  std::ranges::stable_sort(found, std::greater(), &MapMatch::likelihood);
  std::vector<Pose> likely;
  for (const MapMatch& match : found) {
    if (likely.size() == kWorthAMatch) break;
    const bool is_new = std::ranges::none_of(
        likely, [&](const Pose& other) { return is_same_place(other, match.T_map_lidar); });
    if (is_new) likely.push_back(match.T_map_lidar);
  }
  return likely;
}

std::optional<Placement> place_anywhere(const MatchGrid& grid, const QueryScan& query,
                                        const std::vector<Pose>& places) {
  MapMatch best;
  for (const Pose& place : likely_places(grid, query, places)) {
    const MapMatch found = match_to_map(grid, query.points_m, place);
    if (found.is_good && found.likelihood > best.likelihood) best = found;
  }
  if (!best.is_good) return std::nullopt;
  return Placement{best.T_map_lidar * query.T_own_lidar.inverse(), query.scan};
}

void confirm(const MatchGrid& grid, const std::vector<QueryScan>& queries, Placement& placement) {
  for (const QueryScan& query : queries) {
    const Pose start = placement.T_map_own * query.T_own_lidar;
    const MapMatch found = match_to_map(grid, query.points_m, start);
    if (!found.is_good || !is_same_place(found.T_map_lidar, start)) continue;
    placement.support += found.likelihood;
    ++placement.confirmed;
  }
}

constexpr std::size_t kComparedScans = 8;

Result<std::optional<double>> ratio_to_map(const MatchGrid& grid, const Drive& drive,
                                           std::size_t scan, const Pose& T_map_lidar) {
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, scan, ThinnedFor::kMatch));
  const auto match = [&](const std::vector<Eigen::Vector3d>& scaled_m) {
    const MapMatch found = match_to_map(grid, scaled_m, T_map_lidar);
    return FitAtScale{found.likelihood * found.scored_share, found.is_good};
  };
  const std::optional<double> scale = best_scale(thinned.to_match_m, match);
  return scale ? std::optional(1.0 / *scale) : std::nullopt;
}

}  // namespace

MapMatch match_to_map(const MatchGrid& grid, const std::vector<Eigen::Vector3d>& points_m,
                      const Pose& T_map_start) {
  const MatchResult found = match(grid, points_m, T_map_start);
  MapMatch result{found.T_map_sensor, found.nearest_voxel_likelihood};
  result.scored_share = found.scored_points / std::max(1.0, static_cast<double>(points_m.size()));
  result.is_good =
      result.likelihood >= kLeastLikelihood && result.scored_share >= kLeastScoredShare;
  return result;
}

bool is_same_place(const Pose& a, const Pose& b) {
  const Pose between = a.inverse() * b;
  return between.translation().norm() <= kConfirms_m &&
         rotation_angle_rad(between.linear()) <= kConfirms_rad;
}

std::vector<Pose> sensor_places(const Sites& sites, double step_m) {
  std::vector<Pose> places;
  double next_m = 0.0;
  std::optional<std::uint32_t> run;
  for (const Site& site : sites.sites) {
    if (run == site.run && site.s_m < next_m) continue;
    run = site.run;
    next_m = site.s_m + step_m;
    Pose ahead = site.T_map_vehicle;
    ahead.translation() = site.p_map_m;
    places.push_back(ahead);
    Pose back = ahead;
    back.linear() = ahead.linear() * rotation_matrix({Eigen::Vector3d::UnitZ(), std::numbers::pi});
    places.push_back(back);
  }
  return places;
}

Result<std::optional<Placement>> place_piece(const PassContext& ctx, const MatchGrid& grid,
                                             const Drive& drive, const ScanRange& piece,
                                             const std::vector<Pose>& T_own_lidar,
                                             const std::vector<Pose>& places) {
  SIGHTLINE_ASSIGN(const std::vector<QueryScan> queries, make_queries(drive, piece, T_own_lidar));
  std::vector<std::optional<Placement>> found(queries.size() + 1);
  found.back() = Placement{Pose::Identity(), queries.front().scan};
  parallel_for(queries.size(), ctx.threads,
               [&](std::size_t i) { found[i] = place_anywhere(grid, queries[i], places); });
  parallel_for(found.size(), ctx.threads, [&](std::size_t i) {
    if (found[i]) confirm(grid, queries, *found[i]);
  });
  std::optional<Placement> best;
  for (const std::optional<Placement>& placement : found) {
    if (placement && (!best || placement->support > best->support)) best = placement;
  }
  // A scan confirms its own place: a second one is needed.
  if (best && best->confirmed < (queries.size() > 1 ? 2 : 1)) best.reset();
  return best;
}

Result<double> scale_against_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                 const std::vector<Pose>& T_map_lidar,
                                 const std::vector<std::uint8_t>& is_matched) {
  std::vector<std::size_t> matched;
  for (std::size_t k = 0; k < is_matched.size(); ++k) {
    if (is_matched[k] != 0) matched.push_back(k);
  }
  std::vector<std::size_t> scans;
  for (const std::size_t i : evenly(matched.size(), kComparedScans)) scans.push_back(matched[i]);
  SIGHTLINE_ASSIGN(const std::vector<double> ratios,
                   ratios_of_scans(ctx.threads, scans.size(), [&](std::size_t i) {
                     return ratio_to_map(grid, drive, scans[i], T_map_lidar[scans[i]]);
                   }));
  return common_ratio(ratios);
}

}  // namespace sightline
