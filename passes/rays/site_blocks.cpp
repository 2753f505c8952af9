#include "passes/rays/site_blocks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

TileKey block_key(const Eigen::Vector3d& point_m) {
  return {floor_to_int(point_m.x() / kSiteBlock_m), floor_to_int(point_m.y() / kSiteBlock_m)};
}

// Distance in the plane from a point to the square of a block; 0 inside.
double distance_to_block_m(const Eigen::Vector3d& point_m, const TileKey& block) {
  const double low_x = block.x * kSiteBlock_m;
  const double low_y = block.y * kSiteBlock_m;
  const double dx = std::max({low_x - point_m.x(), point_m.x() - low_x - kSiteBlock_m, 0.0});
  const double dy = std::max({low_y - point_m.y(), point_m.y() - low_y - kSiteBlock_m, 0.0});
  return portable_hypot(dx, dy);
}

struct PlacedPatch {
  TileKey block;
  const SurfacePatch* patch = nullptr;
};

std::tuple<TileKey, CellKey, double> order_in_scene(const PlacedPatch& placed) {
  return {placed.block, placed.patch->key, placed.patch->half_side_m};
}

}  // namespace

std::vector<SiteBlock> blocks_of_sites(const Sites& sites) {
  std::map<TileKey, SiteBlock> blocks;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    blocks[block_key(sites.sites[i].p_map_m)].sites.push_back(i);
  }
  std::vector<SiteBlock> list;
  for (auto& [key, block] : blocks) {
    block.key = key;
    block.origin_m = {
        key.x * kSiteBlock_m, key.y * kSiteBlock_m,
        std::floor(sites.sites[block.sites[0]].p_map_m.z() / kSiteBlock_m) * kSiteBlock_m};
    list.push_back(std::move(block));
  }
  return list;
}

Eigen::AlignedBox2d box_around(const SiteBlock& block, double reach_m) {
  const Eigen::Vector2d low_m = block.origin_m.head<2>();
  const Eigen::Vector2d around_m = Eigen::Vector2d::Constant(reach_m);
  return {low_m - around_m, low_m + Eigen::Vector2d::Constant(kSiteBlock_m) + around_m};
}

std::vector<SurfacePatch> patches_near(const SiteBlock& block, const Surface& surface,
                                       double reach_m) {
  std::vector<PlacedPatch> near;
  for (const SurfacePatch& patch : surface.patches) {
    if (distance_to_block_m(patch.centre_m, block.key) > reach_m) continue;
    near.push_back({block_key(patch.centre_m), &patch});
  }
  // As they are where the surface's tiles are as large as blocks.
  if (!std::ranges::is_sorted(near, {}, order_in_scene))
    std::ranges::sort(near, {}, order_in_scene);
  std::vector<SurfacePatch> patches;
  patches.reserve(near.size());
  for (const PlacedPatch& placed : near) patches.push_back(*placed.patch);
  return patches;
}

}  // namespace sightline
