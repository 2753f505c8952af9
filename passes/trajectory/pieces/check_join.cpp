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

// Scans that are compared, at most; and how far apart on the way, at least.
constexpr std::size_t kMostProbes = 12;
constexpr double kProbeEvery_m = 10.0;
// Scans this near, plus the drift of odometry, measure common things.
constexpr double kNear_m = 6.0;
constexpr double kDriftShare = 0.01;
constexpr double kLargestDrift_m = 4.0;
// Reach of the search around the place of a scan.
constexpr double kPlaceReach_m = 1.0;
// Least overlap in the right place, even where houses were rebuilt.
constexpr double kLeastOverlap = 0.5;
// A piece with as many scans needs as many near ones; this share of them must fit.
constexpr std::size_t kFewestProbes = 3;
constexpr double kLeastShareFitting = 0.66;

// The places of scans, and their ranges.
struct Places {
  PointGrid places;
  std::vector<std::pair<std::uint32_t, ScanRange>> scans;
};

Places places_of(const Odometry& odometry, std::span<const ScanRange> ranges) {
  Places seen;
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

// A scan of the piece, and the scan of the others that it passes nearest.
struct Probe {
  std::uint32_t scan = 0;
  std::size_t near = 0;  // of Places::scans
  Pose T_others_lidar = Pose::Identity();
  double drift_m = 0.0;
};

// At most so many, evenly spread over them.
std::vector<Probe> thinned_out(const std::vector<Probe>& all) {
  if (all.size() <= kMostProbes) return all;
  std::vector<Probe> some;
  for (std::size_t i = 0; i < kMostProbes; ++i) some.push_back(all[i * all.size() / kMostProbes]);
  return some;
}

// Whether a scan fits at its place, or as far off as odometry may have drifted. Errors: those of
// reading a scan.
Result<bool> fits(const Drive& drive, const Odometry& odometry, const Places& seen,
                  const Probe& probe) {
  const auto& [middle, range] = seen.scans[probe.near];
  SIGHTLINE_ASSIGN(const Visit visit, make_visit(drive, odometry, range, middle, /*threads=*/1));
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, probe.scan, ThinnedFor::kMatch));
  const std::vector<Eigen::Vector3d> upright_m =
      upright_points(thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  const auto is_within = [&](double reach_m) {
    const LocalMatch match =
        search_locally(visit.grids, thinned.to_match_m, probe.T_others_lidar, reach_m);
    const std::optional<double> overlap = visit.upright.overlap(upright_m, match.T_map_lidar);
    return match.is_good() && overlap.value_or(0.0) >= kLeastOverlap;
  };
  return is_within(kPlaceReach_m) || is_within(kPlaceReach_m + probe.drift_m);
}

}  // namespace

Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const PlacedPiece& placed) {
  const Places seen = places_of(odometry, others);
  const std::vector<std::uint32_t> along = scans_every(odometry, placed.scans, kProbeEvery_m);
  std::vector<Probe> near;
  for (const std::uint32_t scan : along) {
    const Pose T_others_lidar = placed.T_others_piece * odometry.T_map_lidar[scan];
    const double way_m = std::abs(odometry.driven_m[scan] - odometry.driven_m[placed.from]);
    const double drift_m = std::min(kDriftShare * way_m, kLargestDrift_m);
    const std::optional<NearPoint> nearest =
        seen.places.nearest(T_others_lidar.translation(), kNear_m + drift_m);
    if (nearest) near.push_back({scan, nearest->index, T_others_lidar, drift_m});
  }
  // A long piece that only touches the others may be anywhere else.
  if (near.size() < kFewestProbes) return along.size() < kFewestProbes;
  const std::vector<Probe> probes = thinned_out(near);
  SIGHTLINE_ASSIGN(const std::vector<bool> fit,
                   parallel_results<bool>(probes.size(), ctx.threads, [&](std::size_t i) {
                     return fits(drive, odometry, seen, probes[i]);
                   }));
  const auto fitting = std::ranges::count(fit, true);
  return static_cast<double>(fitting) >= kLeastShareFitting * static_cast<double>(probes.size());
}

}  // namespace sightline
