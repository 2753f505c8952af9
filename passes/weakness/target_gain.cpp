#include "passes/weakness/target_gain.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "formats/surroundings/cell_moments.h"

namespace sightline {
namespace {

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

double facing_deg(const Target& target) {
  const double facing_rad = portable_atan2(target.facing.y(), target.facing.x());
  return facing_rad * 180.0 / std::numbers::pi;
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
  if (!is_hit) return std::nullopt;
  return distance_m;
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
