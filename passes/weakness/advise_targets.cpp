#include "passes/weakness/advise_targets.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/surroundings/cell_moments.h"
#include "passes/factors/virtual_scan.h"

namespace sightline {
namespace {

constexpr double kLevel = 0.9;          // height of the normal of ground at least
constexpr double kBelowSensor_m = 0.5;  // ground is lower than the sensor by this at least

bool is_ground(const Nd& nd) {
  return dimension_class(nd) == 2 && std::abs(nd.eigenvectors(2, 2)) > kLevel;
}

double distance_to_route_m(const Sites& sites, const Eigen::Vector2d& place_m) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Site& site : sites.sites) {
    nearest_m = std::min(nearest_m, (site.p_map_m.head<2>() - place_m).norm());
  }
  return nearest_m;
}

struct Place {
  Target target;
  double beside_m = 0.0;
  std::size_t nearest_site = 0;
};

std::vector<double> offsets_m(const AdviceOptions& options) {
  std::vector<double> offsets;
  for (double off_m = options.nearest_m; off_m <= options.farthest_m + 1e-9;
       off_m += options.across_step_m) {
    offsets.push_back(off_m);
    offsets.push_back(-off_m);
  }
  return offsets;
}

std::optional<Place> place_beside(const AdviceOptions& options, const StretchScene& scene,
                                  std::size_t site, double beside_m) {
  const Site& at = scene.sites.sites[site];
  const Eigen::Vector3d left = at.T_map_vehicle.linear().col(1);
  const Eigen::Vector2d place_m = at.p_map_m.head<2>() + beside_m * left.head<2>().normalized();
  if (distance_to_route_m(scene.sites, place_m) < options.nearest_m - 0.1) return std::nullopt;
  const std::optional<double> ground_m = ground_height_m(scene.nds, place_m, at.p_map_m);
  if (!ground_m) return std::nullopt;
  const SinCos facing = portable_sin_cos(scene.loose_heading_deg * std::numbers::pi / 180.0);
  Place place;
  place.target.foot_map_m = {place_m.x(), place_m.y(), *ground_m};
  place.target.facing = {facing.cos, facing.sin};
  place.target.size = options.size;
  place.beside_m = beside_m;
  place.nearest_site = site;
  if (is_taken(scene.nds, place.target, options.clear_m)) return std::nullopt;
  return place;
}

std::vector<Place> places_of(const AdviceOptions& options, const StretchScene& scene) {
  const std::vector<Site>& sites = scene.sites.sites;
  const std::uint32_t run = sites[scene.first_site].run;
  const double from_m = sites[scene.first_site].s_m - options.beyond_m;
  const double to_m = sites[scene.last_site].s_m + options.beyond_m;
  std::vector<Place> places;
  double next_m = -std::numeric_limits<double>::infinity();
  for (std::size_t site = 0; site < sites.size(); ++site) {
    const double s_m = sites[site].s_m;
    if (sites[site].run != run || s_m < from_m || s_m > to_m || s_m < next_m) continue;
    next_m = s_m + options.along_step_m - 1e-6;
    for (const double beside_m : offsets_m(options)) {
      const std::optional<Place> place = place_beside(options, scene, site, beside_m);
      if (place) places.push_back(*place);
    }
  }
  return places;
}

TargetAdvice judge(const StretchScene& scene, const Place& place) {
  TargetAdvice advice{place.target, place.beside_m, place.nearest_site};
  std::vector<std::vector<TargetHit>> hits;
  for (const SiteView& view : scene.views) {
    hits.push_back(hits_of(place.target, view, scene.directions, scene.view.range_m));
    advice.return_count = std::max(advice.return_count, hits.back().size());
  }
  if (advice.return_count == 0) return advice;
  std::vector<WeightedHits> weighted;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    weighted.push_back({scene.views[i], hits[i], scene.weights[i]});
  }
  const ChangedNds changed = nds_with_target(scene.nds, weighted, scene.directions);
  const TargetScene with_target{scene.nds, changed, scene.directions, scene.view.leaf_m};
  const auto count = static_cast<double>(scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SiteView& view = scene.views[i];
    const double before_m = std_along_m(crlb(view.information), scene.loose_heading_deg);
    const Crlb after = crlb(information_with_target(view, hits[i], with_target));
    const double with_m =
        std_with_more_m(scene.std_m[i], before_m, std_along_m(after, scene.loose_heading_deg));
    advice.std_before_m += scene.std_m[i] / count;
    advice.std_after_m += with_m / count;
    if (i == 0) advice.gain_at_worst = 1.0 - with_m / scene.std_m[i];
  }
  advice.gain = 1.0 - advice.std_after_m / advice.std_before_m;
  return advice;
}

constexpr double kLeastPoints = 10.0;        // of a valid ND ("NDT map" in definitions.md)
constexpr double kLeastVariance_m2 = 1e-6;   // likewise
constexpr double kSmallestSine = 0.0104719;  // seen at 0.6 degrees or more, as any patch
constexpr double kNearest_m = 0.5;           // of a hit

// Of a board's points in a map: noise of ranges and errors of poses, 2 cm each, as simulated scans
// have them ("Annotating a finished map" in definitions.md).
constexpr double kPointVariance_m2 = 2.0 * 0.02 * 0.02;

using Moments = std::map<CellKey, CellMoments>;

void add_hits(const WeightedHits& seen, const std::vector<Eigen::Vector3d>& directions,
              double cell_m, Moments& moments) {
  for (const TargetHit& hit : seen.hits) {
    const Eigen::Vector3d at_m = seen.view.p_map_m + hit.distance_m * directions[hit.beam];
    const CellKey key = cell_key(at_m, cell_m);
    const Eigen::Vector3d from_centre_m = at_m - cell_centre_m(key, cell_m);
    CellMoments& cell = moments[key];
    cell.count += seen.weight;
    cell.sum_m += seen.weight * from_centre_m;
    cell.products_m2 += seen.weight * (from_centre_m * from_centre_m.transpose() +
                                       kPointVariance_m2 * Eigen::Matrix3d::Identity());
  }
}

const Eigen::Matrix3d* information_at(const TargetScene& scene, const CellKey& key) {
  const auto changed = scene.changed.find(key);
  return changed != scene.changed.end() ? &changed->second : scene.nds.information_at(key);
}

// The view's voxels that hold another number of returns than before, as they are with the target.
std::map<CellKey, ScanVoxel> touched_voxels(const SiteView& view,
                                            const std::vector<TargetHit>& hits,
                                            const TargetScene& scene) {
  std::map<CellKey, ScanVoxel> touched;
  const auto move = [&](const Eigen::Vector3d& point_m, double count) {
    const CellKey key = cell_key(point_m, scene.leaf_m);
    const auto before = view.voxels.find(key);
    const ScanVoxel start = before == view.voxels.end() ? ScanVoxel{} : before->second;
    ScanVoxel& voxel = touched.try_emplace(key, start).first->second;
    voxel.sum_m += count * point_m;
    voxel.count += count;
  };
  for (const TargetHit& hit : hits) {
    const double before_m = view.distance_m[hit.beam];
    if (std::isfinite(before_m)) move(before_m * scene.directions[hit.beam], -1.0);
    move(hit.distance_m * scene.directions[hit.beam], 1.0);
  }
  return touched;
}

}  // namespace

double std_with_more_m(double std_m, double before_m, double after_m) {
  const double more = 1.0 / (after_m * after_m) - 1.0 / (before_m * before_m);
  const double information = 1.0 / (std_m * std_m) + more;
  // A board that hides more than it shows takes away at most all that there was.
  return 1.0 / std::sqrt(std::max(information, 0.01 / (std_m * std_m)));
}

std::optional<double> ground_height_m(const NearNds& nds, const Eigen::Vector2d& place_m,
                                      const Eigen::Vector3d& p_map_m) {
  const CellKey column = cell_key({place_m.x(), place_m.y(), 0.0}, nds.cell_m);
  std::optional<double> lowest_m;
  for (const Nd& nd : nds.nds) {
    if (nd.key.x != column.x || nd.key.y != column.y || !is_ground(nd)) continue;
    const Eigen::Vector3d normal = nd.eigenvectors.col(2);
    const Eigen::Vector2d off_m = place_m - nd.mean_m.head<2>();
    const double height_m = nd.mean_m.z() - normal.head<2>().dot(off_m) / normal.z();
    if (height_m > p_map_m.z() - kBelowSensor_m) continue;
    lowest_m = std::min(height_m, lowest_m.value_or(height_m));
  }
  return lowest_m;
}

bool is_taken(const NearNds& nds, const Target& target, double clear_m) {
  constexpr double kAboveGround_m = 0.3;  // what is lower is a kerb
  const double low_m = target.foot_map_m.z() + kAboveGround_m;
  const double high_m = target.foot_map_m.z() + target.size.bottom_m + target.size.height_m;
  return std::ranges::any_of(nds.nds, [&](const Nd& nd) {
    if (is_ground(nd)) return false;
    const double half_height_m = std::sqrt(3.0 * nd.covariance_m2(2, 2));
    if (nd.mean_m.z() + half_height_m < low_m || nd.mean_m.z() - half_height_m > high_m) {
      return false;
    }
    const Eigen::Vector2d off_m = target.foot_map_m.head<2>() - nd.mean_m.head<2>();
    const double away_m = off_m.norm();
    const double reach_m = clear_m + 0.5 * target.size.width_m;
    if (away_m <= reach_m) return true;
    const Eigen::Vector2d way = off_m / away_m;
    const Eigen::Matrix2d spread_m2 = nd.covariance_m2.topLeftCorner<2, 2>();
    const double half_extent_m = std::sqrt(3.0 * way.dot(spread_m2 * way));
    return away_m - half_extent_m < reach_m;
  });
}

std::vector<TargetAdvice> advise_targets(const PassContext& ctx, const AdviceOptions& options,
                                         const StretchScene& scene) {
  if (options.most == 0) return {};
  const std::vector<Place> places = places_of(options, scene);
  std::vector<TargetAdvice> judged = parallel_map<TargetAdvice>(
      places.size(), ctx.threads, [&](std::size_t i) { return judge(scene, places[i]); });
  std::ranges::stable_sort(
      judged, [](const TargetAdvice& a, const TargetAdvice& b) { return a.gain > b.gain; });
  std::vector<TargetAdvice> best;
  for (const TargetAdvice& one : judged) {
    if (best.size() == options.most || !(one.gain > 0.0)) break;
    const bool is_near = std::ranges::any_of(best, [&](const TargetAdvice& other) {
      return (other.target.foot_map_m - one.target.foot_map_m).norm() < options.apart_m;
    });
    if (!is_near) best.push_back(one);
  }
  return best;
}

double facing_deg(const Target& target) {
  return portable_atan2(target.facing.y(), target.facing.x()) * 180.0 / std::numbers::pi;
}

std::optional<double> distance_to_target_m(const Target& target, const Eigen::Vector3d& p_map_m,
                                           const Eigen::Vector3d& direction) {
  const Eigen::Vector3d normal(target.facing.x(), target.facing.y(), 0.0);
  const double sine = normal.dot(direction);
  if (std::abs(sine) < kSmallestSine) return std::nullopt;
  const double distance_m = normal.dot(target.foot_map_m - p_map_m) / sine;
  if (!(distance_m >= kNearest_m)) return std::nullopt;
  const Eigen::Vector3d from_foot_m = p_map_m + distance_m * direction - target.foot_map_m;
  const double across_m = normal.x() * from_foot_m.y() - normal.y() * from_foot_m.x();
  const double up_m = from_foot_m.z() - target.size.bottom_m;
  const bool is_hit = std::abs(across_m) <= 0.5 * target.size.width_m && up_m >= 0.0 &&
                      up_m <= target.size.height_m;
  return is_hit ? std::optional(distance_m) : std::nullopt;
}

std::vector<TargetHit> hits_of(const Target& target, const SiteView& view,
                               const std::vector<Eigen::Vector3d>& directions, double range_m) {
  std::vector<TargetHit> hits;
  for (std::size_t beam = 0; beam < directions.size(); ++beam) {
    const std::optional<double> distance_m =
        distance_to_target_m(target, view.p_map_m, directions[beam]);
    if (!distance_m || *distance_m > range_m || !(*distance_m < view.distance_m[beam])) continue;
    hits.push_back({beam, *distance_m});
  }
  return hits;
}

ChangedNds nds_with_target(const NearNds& nds, const std::vector<WeightedHits>& hits,
                           const std::vector<Eigen::Vector3d>& directions) {
  Moments moments;
  for (const WeightedHits& seen : hits) add_hits(seen, directions, nds.cell_m, moments);
  ChangedNds changed;
  for (auto& [key, cell] : moments) {
    const std::uint32_t number = nds.index.find(key);
    if (number != CellIndex::kNone) {
      const Nd& nd = nds.nds[number];
      cell.add(nd, nd.mean_m - cell_centre_m(key, nds.cell_m));
    }
    if (cell.count < kLeastPoints) continue;
    const Nd nd = nd_of(key, cell, nds.cell_m);
    if (nd.eigenvalues_m2[0] < kLeastVariance_m2) continue;
    changed.emplace(key, regularised_covariance_m2(nd).inverse());
  }
  return changed;
}

Matrix6d information_with_target(const SiteView& view, const std::vector<TargetHit>& hits,
                                 const TargetScene& scene) {
  const std::map<CellKey, ScanVoxel> touched = touched_voxels(view, hits, scene);
  Matrix6d information = view.information;
  const double cell_m = scene.nds.cell_m;
  for (const auto& [key, voxel] : view.voxels) {
    const CellKey cell = cell_of(voxel, view.p_map_m, cell_m);
    const bool is_touched = touched.contains(key);
    if (!is_touched && !scene.changed.contains(cell)) continue;
    add_voxel(voxel, scene.nds.information_at(cell), -1.0, information);
    if (!is_touched) add_voxel(voxel, information_at(scene, cell), 1.0, information);
  }
  for (const auto& [key, voxel] : touched) {
    if (voxel.count < 0.5) continue;  // every return of it ends at the target now
    const CellKey cell = cell_of(voxel, view.p_map_m, cell_m);
    add_voxel(voxel, information_at(scene, cell), 1.0, information);
  }
  return information;
}

}  // namespace sightline
