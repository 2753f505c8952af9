#include "passes/weakness/site_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "passes/map/build_nd_surface.h"
#include "passes/rays/surface_caster.h"

namespace sightline {
namespace {

std::map<CellKey, ScanVoxel> voxels_of(const std::vector<Eigen::Vector3d>& directions,
                                       std::span<const double> distance_m, double leaf_m) {
  std::map<CellKey, ScanVoxel> voxels;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!std::isfinite(distance_m[i])) continue;
    const Eigen::Vector3d hit_m = distance_m[i] * directions[i];
    ScanVoxel& voxel = voxels[cell_key(hit_m, leaf_m)];
    voxel.sum_m += hit_m;
    voxel.count += 1.0;
  }
  return voxels;
}

}  // namespace

const Eigen::Matrix3d* NearNds::information_at(const CellKey& key) const {
  const std::uint32_t number = index.find(key);
  return number == CellIndex::kNone ? nullptr : &information_per_m2[number];
}

NearNds nds_near(const NdtMap& map, const std::vector<Eigen::Vector3d>& places_m, double reach_m) {
  NearNds near;
  near.cell_m = map.cell_m;
  for (const Nd& nd : map.nds) {
    const bool is_near = std::ranges::any_of(places_m, [&](const Eigen::Vector3d& place_m) {
      return (nd.mean_m - place_m).head<2>().squaredNorm() <= reach_m * reach_m;
    });
    if (!is_near) continue;
    near.index.add(nd.key);
    near.nds.push_back(nd);
    near.information_per_m2.emplace_back(regularised_covariance_m2(nd).inverse());
  }
  return near;
}

CellKey cell_of(const ScanVoxel& voxel, const Eigen::Vector3d& p_map_m, double cell_m) {
  return cell_key(p_map_m + voxel.sum_m / voxel.count, cell_m);
}

void add_voxel(const ScanVoxel& voxel, const Eigen::Matrix3d* information_per_m2, double sign,
               Matrix6d& information) {
  if (information_per_m2 == nullptr) return;
  add_sample(voxel.sum_m / voxel.count, sign * *information_per_m2, information);
}

Result<std::vector<SiteView>> views_from(PassContext& ctx, const ViewOptions& options,
                                         const NearNds& nds, const Sites& sites,
                                         const std::vector<std::size_t>& of,
                                         const std::vector<Eigen::Vector3d>& directions) {
  Sites seen_from;
  seen_from.frame = sites.frame;
  std::vector<SiteView> views(of.size());
  for (std::size_t i = 0; i < of.size(); ++i) {
    seen_from.sites.push_back(sites.sites[of[i]]);
    views[i].site = of[i];
    views[i].p_map_m = sites.sites[of[i]].p_map_m;
  }
  const RayFan fan{directions, options.near_m, options.range_m, options.view};
  const Surface surface = surface_of_nds({sites.frame, nds.cell_m, nds.cell_m, nds.nds, 0, 0, 0});
  SIGHTLINE_TRY(cast_at_sites(ctx, surface, seen_from, fan,
                              [&](std::size_t i, std::span<const double> distance_m) {
                                SiteView& view = views[i];
                                view.distance_m.assign(distance_m.begin(), distance_m.end());
                                view.voxels = voxels_of(directions, distance_m, options.leaf_m);
                                for (const auto& [key, voxel] : view.voxels) {
                                  const CellKey cell = cell_of(voxel, view.p_map_m, nds.cell_m);
                                  add_voxel(voxel, nds.information_at(cell), 1.0, view.information);
                                }
                              }));
  return views;
}

}  // namespace sightline
