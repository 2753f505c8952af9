#include "passes/trajectory/pieces/seek_piece.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include "formats/base/level.h"
#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/grid/point_grid.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/surface_between.h"

namespace sightline {
namespace {

// Maps of an earlier piece, from its end back: one every so much of the way, from the scans of so
// much of the way before and after, one in so much.
constexpr double kVisitEvery_m = 25.0;
constexpr double kVisitReach_m = 20.0;
constexpr double kVisitStep_m = 1.5;
// Scans of the later piece that are searched for: so far from its beginning, and so far from its
// end.
constexpr double kQueryWays_m[] = {0.0, 2.0, 5.0, 10.0, 20.0, 40.0};
constexpr double kLastQueries_m[] = {0.0, 20.0};
constexpr std::size_t kFewScans = 6;
// The least overlap of one scan; how many scans must agree, and which share of those that found a
// place.
constexpr double kLeastOverlap = 0.4;
constexpr std::size_t kLeastAgreeing = 2;
constexpr double kLeastShareAgreeing = 0.6;

std::vector<std::uint32_t> query_scans(const Odometry& odometry, const ScanRange& range) {
  std::vector<std::uint32_t> scans;
  const auto begin = odometry.driven_m.begin();
  const auto at = [&](double driven_m) {
    const auto found = std::lower_bound(begin + range.begin, begin + range.end, driven_m);
    if (found != begin + range.end) scans.push_back(static_cast<std::uint32_t>(found - begin));
  };
  for (const double way_m : kQueryWays_m) at(odometry.driven_m[range.begin] + way_m);
  for (const double way_m : kLastQueries_m) {
    if (way_m <= odometry.driven_m[range.end - 1] - odometry.driven_m[range.begin]) {
      at(odometry.driven_m[range.end - 1] - way_m);
    }
  }
  // A vehicle that stands still has too few scans by way: its first ones are added.
  for (std::uint32_t k = range.begin; scans.size() < kFewScans && k < range.end; ++k) {
    scans.push_back(k);
  }
  std::ranges::sort(scans);
  scans.erase(std::unique(scans.begin(), scans.end()), scans.end());
  return scans;
}

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
constexpr double kLeastOverlapAlong = 0.5;
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
    return match.is_good() && overlap.value_or(0.0) >= kLeastOverlapAlong;
  };
  return is_within(kPlaceReach_m) || is_within(kPlaceReach_m + probe.drift_m);
}

// The scan of each other level above or below a place that is nearest to it in the plane.
std::vector<std::pair<std::uint32_t, ScanRange>> scans_on_other_levels(
    const Odometry& odometry, std::span<const ScanRange> others, const Eigen::Vector3d& place_m) {
  struct Beside {
    double distance_m;
    std::uint32_t scan;
    ScanRange range;
  };
  std::vector<Beside> beside;
  for (const ScanRange& range : others) {
    for (std::uint32_t k = range.begin; k < range.end; ++k) {
      const Eigen::Vector3d away_m = odometry.T_map_lidar[k].translation() - place_m;
      const double distance_m = away_m.head<2>().norm();
      if (distance_m > kNear_m || is_same_level(away_m.z(), 0.0)) continue;
      beside.push_back({distance_m, k, range});
    }
  }
  std::ranges::stable_sort(beside, {}, &Beside::distance_m);
  std::vector<std::pair<std::uint32_t, ScanRange>> taken;
  const auto z_m = [&](std::uint32_t k) { return odometry.T_map_lidar[k].translation().z(); };
  for (const Beside& one : beside) {
    const bool is_known = std::ranges::any_of(
        taken, [&](const auto& other) { return is_same_level(z_m(other.first), z_m(one.scan)); });
    if (!is_known) taken.emplace_back(one.scan, one.range);
  }
  return taken;
}

// A place has the keys of one scan in so much of the way, within so much of its middle.
constexpr double kKeyEvery_m = 5.0;
constexpr double kKeyReach_m = 15.0;

constexpr double kRing_m = 2.0;
constexpr std::size_t kDirections = 60;

}  // namespace

Result<Visit> make_visit(const Drive& drive, const Odometry& odometry, const ScanRange& range,
                         std::uint32_t middle, int threads) {
  std::vector<std::uint32_t> scans;
  double next_m = odometry.driven_m[middle] - kVisitReach_m;
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (odometry.driven_m[k] > odometry.driven_m[middle] + kVisitReach_m) break;
    if (odometry.driven_m[k] < next_m && k != middle) continue;
    next_m = odometry.driven_m[k] + kVisitStep_m;
    scans.push_back(k);
  }
  SIGHTLINE_ASSIGN(const std::vector<ThinnedScan> read,
                   parallel_results<ThinnedScan>(scans.size(), threads, [&](std::size_t i) {
                     return read_thinned(drive, scans[i], ThinnedFor::kMap);
                   }));
  Visit visit;
  visit.middle = middle;
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Pose& T_map_lidar = odometry.T_map_lidar[scans[i]];
    const std::vector<Eigen::Vector3d>& scan_m = read[i].to_map_m;
    for (const Eigen::Vector3d& point_m : scan_m) visit.points_m.push_back(T_map_lidar * point_m);
    visit.upright.add(upright_points(scan_m, level), T_map_lidar, odometry.driven_m[scans[i]]);
  }
  visit.grids = local_grids(visit.points_m);
  return visit;
}

std::vector<std::uint32_t> middles_of(const Odometry& odometry, const ScanRange& range) {
  std::vector<std::uint32_t> middles;
  double next_m = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = range.end; k-- > range.begin;) {
    if (odometry.driven_m[k] > next_m) continue;
    middles.push_back(k);
    next_m = odometry.driven_m[k] - kVisitEvery_m;
  }
  return middles;
}

Result<std::vector<Query>> read_queries(const Drive& drive, const Odometry& odometry,
                                        const ScanRange& range) {
  std::vector<Query> queries;
  for (const std::uint32_t scan : query_scans(odometry, range)) {
    Query& query = queries.emplace_back();
    query.scan = scan;
    SIGHTLINE_ASSIGN(query.thinned, read_thinned(drive, scan, ThinnedFor::kMatch));
    query.upright_m =
        upright_points(query.thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  }
  return queries;
}

std::vector<Hypothesis> look_for(const PassContext& ctx, const Visit& visit,
                                 const Odometry& odometry, const std::vector<Query>& queries) {
  const std::vector<std::optional<WidePlacement>> placed =
      parallel_map<std::optional<WidePlacement>>(queries.size(), ctx.threads, [&](std::size_t i) {
        return place_widely({visit.grids, visit.upright},
                            {queries[i].thinned.to_match_m, queries[i].upright_m},
                            odometry.T_map_lidar[visit.middle], {.least_share = kLeastOverlap});
      });
  std::vector<Hypothesis> found;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (!placed[i] || placed[i]->overlap < kLeastOverlap ||
        placed[i]->overlap < placed[i]->overlap_elsewhere + kClearlyMoreOverlap) {
      continue;
    }
    found.push_back({queries[i].scan, placed[i]->match.T_map_lidar, placed[i]->overlap});
  }
  return found;
}

std::vector<Hypothesis> agreeing(const Odometry& odometry, const std::vector<Hypothesis>& found) {
  std::vector<Hypothesis> most;
  for (const Hypothesis& one : found) {
    const Pose T_earlier_later = one.T_map_lidar * odometry.T_map_lidar[one.scan].inverse();
    std::vector<Hypothesis> with_it = {one};
    for (const Hypothesis& other : found) {
      if (other.scan == one.scan) continue;
      const Pose expected = T_earlier_later * odometry.T_map_lidar[other.scan];
      if (!are_elsewhere(expected, other.T_map_lidar)) with_it.push_back(other);
    }
    if (with_it.size() > most.size()) most = std::move(with_it);
  }
  const double least = kLeastShareAgreeing * static_cast<double>(found.size());
  if (most.size() < kLeastAgreeing || static_cast<double>(most.size()) < least) return {};
  return most;
}

Result<bool> fits_another_level(const PassContext& ctx, const Drive& drive,
                                const Odometry& odometry, std::span<const ScanRange> others,
                                const FoundPiece& found) {
  const Pose& T_map_found = found.agreed.front().T_map_lidar;
  for (const auto& [middle, range] :
       scans_on_other_levels(odometry, others, T_map_found.translation())) {
    SIGHTLINE_ASSIGN(const Visit visit, make_visit(drive, odometry, range, middle, ctx.threads));
    const Eigen::Vector3d there_m = odometry.T_map_lidar[middle].translation();
    const double higher_m = there_m.z() - T_map_found.translation().z();
    const Visit& lower = higher_m > 0.0 ? found.visit : visit;
    if (!is_surface_between(lower.points_m, T_map_found.translation(), there_m)) continue;
    std::size_t fitting = 0;
    for (const Hypothesis& one : found.agreed) {
      const auto query = std::ranges::find(found.queries, one.scan, &Query::scan);
      const Pose T_map_start = Eigen::Translation3d(0.0, 0.0, higher_m) * one.T_map_lidar;
      const LocalMatch match =
          search_locally(visit.grids, query->thinned.to_match_m, T_map_start, kPlaceReach_m);
      const double overlap = visit.upright.overlap(query->upright_m, match.T_map_lidar).value_or(0);
      fitting += match.is_good() && overlap >= one.overlap - kClearlyMoreOverlap ? 1 : 0;
    }
    if (2 * fitting >= found.agreed.size()) return true;
  }
  return false;
}

Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const PlacedPiece& placed) {
  const Places seen = places_of(odometry, others);
  const std::vector<std::uint32_t> along = scans_every(odometry, placed.scans, kProbeEvery_m);
  std::vector<Probe> near;
  for (const std::uint32_t scan : along) {
    const Pose T_others_lidar = placed.T_others_piece * odometry.T_map_lidar[scan];
    const double way_m = std::abs(odometry.driven_m[scan] - odometry.driven_m[placed.from]);
    const double drift_m = std::min(kDriftShare * way_m, kLargestDrift_m);
    const auto is_on_level = [&](const NearPoint& point) {
      const double other_z_m =
          odometry.T_map_lidar[seen.scans[point.index].first].translation().z();
      return std::abs(other_z_m - T_others_lidar.translation().z()) < kLevelHeight_m + drift_m;
    };
    const std::optional<NearPoint> nearest =
        seen.places.nearest(T_others_lidar.translation(), kNear_m + drift_m, is_on_level);
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

Result<std::vector<std::uint32_t>> PlaceRecognition::before(std::uint32_t later,
                                                            const std::vector<Query>& queries) {
  std::vector<PlaceKey> wanted;
  for (const Query& query : queries) wanted.push_back(place_key(query.upright_m));
  std::vector<std::pair<double, std::uint32_t>> places;
  for (std::uint32_t piece = later; piece-- > 0;) {
    SIGHTLINE_TRY(read_keys(piece));
    for (const std::uint32_t middle : middles_of(odometry_, pieces_[piece])) {
      places.emplace_back(least_difference(piece, middle, wanted), middle);
    }
  }
  std::ranges::stable_sort(places, {}, &std::pair<double, std::uint32_t>::first);
  std::vector<std::uint32_t> middles;
  for (const auto& [difference, middle] : places) middles.push_back(middle);
  return middles;
}

Result<void> PlaceRecognition::read_keys(std::uint32_t piece) {
  if (!keys_[piece].empty()) return {};
  const std::vector<std::uint32_t> scans = scans_every(odometry_, pieces_[piece], kKeyEvery_m);
  const Eigen::Matrix3d level = drive_.sensor.T_vehicle_lidar.linear();
  const auto key_of = [&](std::size_t i) -> Result<PlaceKey> {
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive_, scans[i], ThinnedFor::kMatch));
    return place_key(upright_points(scan.to_match_m, level));
  };
  SIGHTLINE_ASSIGN(const std::vector<PlaceKey> keys,
                   parallel_results<PlaceKey>(scans.size(), ctx_.threads, key_of));
  for (std::size_t i = 0; i < scans.size(); ++i) keys_[piece].emplace_back(scans[i], keys[i]);
  return {};
}

double PlaceRecognition::least_difference(std::uint32_t piece, std::uint32_t middle,
                                          const std::vector<PlaceKey>& wanted) const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [scan, key] : keys_[piece]) {
    if (std::abs(odometry_.driven_m[scan] - odometry_.driven_m[middle]) > kKeyReach_m) continue;
    for (const PlaceKey& one : wanted) least = std::min(least, difference(one, key));
  }
  return least;
}

PlaceKey place_key(const std::vector<Eigen::Vector3d>& upright_m) {
  std::array<std::bitset<kDirections>, std::tuple_size_v<PlaceKey>> rings;
  for (const Eigen::Vector3d& point_m : upright_m) {
    const auto ring = static_cast<std::size_t>(point_m.head<2>().norm() / kRing_m);
    if (ring >= rings.size()) continue;
    const double turns = portable_atan2(point_m.y(), point_m.x()) / (2.0 * std::numbers::pi) + 0.5;
    rings[ring].set(std::min(static_cast<std::size_t>(turns * kDirections), kDirections - 1));
  }
  PlaceKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<float>(rings[i].count());
  return key;
}

double difference(const PlaceKey& a, const PlaceKey& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

}  // namespace sightline
