#include "passes/trajectory/pieces/check_join.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/scan_overlap.h"

namespace sightline {
namespace {

// Scans that are asked, at most; and how far apart on the way, at least.
constexpr std::size_t kMostAsked = 12;
constexpr double kAskEvery_m = 10.0;
// What passes this near, odometry's drift aside, sees the same.
constexpr double kNear_m = 6.0;
constexpr double kDriftShare = 0.01;
constexpr double kLargestDrift_m = 4.0;
// Around where a scan is laid.
constexpr double kLaidReach_m = 1.0;
// So much of a scan meets what was seen in the same place, of houses that were rebuilt since too.
constexpr double kLeastOverlap = 0.5;
// Of a piece that has as many, fewer that come near are no proof; of more, this share must fit.
constexpr std::size_t kFewestAsked = 3;
constexpr double kLeastShareFitting = 0.66;

// Where the scans of ranges were, and which.
struct Seen {
  PointGrid places;
  std::vector<std::pair<std::uint32_t, ScanRange>> scans;
};

Seen seen_by(const Odometry& odometry, std::span<const ScanRange> ranges) {
  Seen seen;
  std::vector<Eigen::Vector3d> places_m;
  for (const ScanRange& range : ranges) {
    for (std::uint32_t k = range.begin; k < range.end; ++k) {
      places_m.push_back(odometry.T_map_lidar[k].translation());
      seen.scans.emplace_back(k, range);
    }
  }
  seen.places = PointGrid(places_m);
  return seen;
}

// Of a piece, evenly along its way.
std::vector<std::uint32_t> scans_along(const Odometry& odometry, const ScanRange& range) {
  std::vector<std::uint32_t> scans;
  double next_m = odometry.driven_m[range.begin];
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (odometry.driven_m[k] < next_m) continue;
    next_m = odometry.driven_m[k] + kAskEvery_m;
    scans.push_back(k);
  }
  return scans;
}

// A scan of the piece and the one of the others that it passes nearest.
struct Asked {
  std::uint32_t scan = 0;
  std::size_t near = 0;  // of Seen::scans
  Pose T_others_lidar = Pose::Identity();
  double drift_m = 0.0;
};

// At most so many, evenly spread over them.
std::vector<Asked> thinned_out(const std::vector<Asked>& all) {
  if (all.size() <= kMostAsked) return all;
  std::vector<Asked> some;
  for (std::size_t i = 0; i < kMostAsked; ++i) some.push_back(all[i * all.size() / kMostAsked]);
  return some;
}

// Whether a scan meets what was seen where it is laid: there, or as far off as odometry may have
// drifted. Errors: what reading a scan says.
Result<bool> fits(const Drive& drive, const Odometry& odometry, const Seen& seen,
                  const Asked& asked) {
  const auto& [middle, range] = seen.scans[asked.near];
  SIGHTLINE_ASSIGN(const Visit visit, make_visit(drive, odometry, range, middle, /*threads=*/1));
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, asked.scan, ThinnedFor::kMatch));
  const std::vector<Eigen::Vector3d> upright_m =
      upright_points(thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  const auto is_within = [&](double reach_m) {
    const LocalMatch match =
        search_locally(visit.grids, thinned.to_match_m, asked.T_others_lidar, reach_m);
    const std::optional<double> overlap = visit.upright.overlap(upright_m, match.T_map_lidar);
    return match.is_good() && overlap.value_or(0.0) >= kLeastOverlap;
  };
  return is_within(kLaidReach_m) || is_within(kLaidReach_m + asked.drift_m);
}

}  // namespace

Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const LaidPiece& laid) {
  const Seen seen = seen_by(odometry, others);
  const std::vector<std::uint32_t> along = scans_along(odometry, laid.scans);
  std::vector<Asked> near;
  for (const std::uint32_t scan : along) {
    const Pose T_others_lidar = laid.T_others_piece * odometry.T_map_lidar[scan];
    const double way_m = std::abs(odometry.driven_m[scan] - odometry.driven_m[laid.from]);
    const double drift_m = std::min(kDriftShare * way_m, kLargestDrift_m);
    const std::optional<NearPoint> nearest =
        seen.places.nearest(T_others_lidar.translation(), kNear_m + drift_m);
    if (nearest) near.push_back({scan, nearest->index, T_others_lidar, drift_m});
  }
  // A long piece that only touches the others may as well lie anywhere else.
  if (near.size() < kFewestAsked) return along.size() < kFewestAsked;
  const std::vector<Asked> asked = thinned_out(near);
  std::vector<Result<bool>> fit(asked.size(), false);
  parallel_for(asked.size(), ctx.threads,
               [&](std::size_t i) { fit[i] = fits(drive, odometry, seen, asked[i]); });
  std::size_t fitting = 0;
  for (const Result<bool>& one : fit) {
    if (!one) return one.error();
    fitting += *one ? 1 : 0;
  }
  return static_cast<double>(fitting) >= kLeastShareFitting * static_cast<double>(asked.size());
}

}  // namespace sightline
