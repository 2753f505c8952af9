#include "passes/trajectory/pieces/check_join.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formats/grid/point_grid.h"
#include "passes/trajectory/local_match.h"
#include "passes/trajectory/pieces/scan_overlap.h"

namespace sightline {
namespace {

// Scans that are asked, at most; and how far apart on the way, at least.
constexpr double kMostAsked = 12.0;
constexpr double kAskEvery_m = 10.0;
// What passes this near, odometry's drift aside, sees the same.
constexpr double kNear_m = 6.0;
constexpr double kDriftShare = 0.01;
constexpr double kLargestDrift_m = 4.0;
// So much of a scan meets what was seen in the same place, of houses that were rebuilt since too.
constexpr double kLeastOverlap = 0.5;
// Fewer say nothing; of more, this share must fit.
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
std::vector<std::uint32_t> asked_scans(const Odometry& odometry, const ScanRange& range) {
  const double way_m = odometry.driven_m[range.end - 1] - odometry.driven_m[range.begin];
  const double step_m = std::max(kAskEvery_m, way_m / kMostAsked);
  std::vector<std::uint32_t> scans;
  double next_m = odometry.driven_m[range.begin];
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (odometry.driven_m[k] < next_m) continue;
    next_m = odometry.driven_m[k] + step_m;
    scans.push_back(k);
  }
  return scans;
}

// Whether a scan meets what was seen where it is laid. Errors: what reading a scan says.
Result<bool> fits(const Drive& drive, const Visit& visit, std::uint32_t scan,
                  const Pose& T_others_lidar, double reach_m) {
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, scan));
  const LocalMatch match = search_locally(visit.grids, thinned.to_match_m, T_others_lidar, reach_m);
  const std::vector<Eigen::Vector3d> upright_m =
      upright_points(thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  const std::optional<double> overlap = visit.upright.overlap(upright_m, match.T_map_lidar);
  return match.is_good() && overlap.value_or(0.0) >= kLeastOverlap;
}

}  // namespace

Result<bool> fits_all_along(const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const LaidPiece& laid) {
  const Seen seen = seen_by(odometry, others);
  std::size_t asked = 0;
  std::size_t fitting = 0;
  for (const std::uint32_t scan : asked_scans(odometry, laid.scans)) {
    const Pose T_others_lidar = laid.T_others_piece * odometry.T_map_lidar[scan];
    const double way_m = std::abs(odometry.driven_m[scan] - odometry.driven_m[laid.from]);
    const double drift_m = std::min(kDriftShare * way_m, kLargestDrift_m);
    const std::optional<NearPoint> near =
        seen.places.nearest(T_others_lidar.translation(), kNear_m + drift_m);
    if (!near) continue;
    const auto& [middle, range] = seen.scans[near->index];
    SIGHTLINE_ASSIGN(const Visit visit, make_visit(drive, odometry, range, middle));
    SIGHTLINE_ASSIGN(const bool does_fit, fits(drive, visit, scan, T_others_lidar, 1.0 + drift_m));
    ++asked;
    fitting += does_fit ? 1 : 0;
  }
  return asked < kFewestAsked ||
         static_cast<double>(fitting) >= kLeastShareFitting * static_cast<double>(asked);
}

}  // namespace sightline
