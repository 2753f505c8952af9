#include "passes/rays/site_blocks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

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

// Ascending by key and side within a block, however the surface was cut into tiles.
using PatchesByBlock = std::map<TileKey, std::vector<std::uint32_t>>;

PatchesByBlock patches_by_block(const Surface& surface) {
  PatchesByBlock by_block;
  for (std::uint32_t i = 0; i < surface.patches.size(); ++i) {
    by_block[block_key(surface.patches[i].centre_m)].push_back(i);
  }
  for (auto& [key, patches] : by_block) {
    std::sort(patches.begin(), patches.end(), [&](std::uint32_t a, std::uint32_t b) {
      const SurfacePatch& patch_a = surface.patches[a];
      const SurfacePatch& patch_b = surface.patches[b];
      if (patch_a.key != patch_b.key) return patch_a.key < patch_b.key;
      return patch_a.half_side_m < patch_b.half_side_m;
    });
  }
  return by_block;
}

std::vector<std::uint32_t> patches_near(const TileKey& block, const PatchesByBlock& by_block,
                                        const Surface& surface, double reach_m) {
  std::vector<std::uint32_t> near;
  const auto rings = static_cast<std::int32_t>(std::ceil(reach_m / kSiteBlock_m));
  for (std::int32_t x = block.x - rings; x <= block.x + rings; ++x) {
    for (std::int32_t y = block.y - rings; y <= block.y + rings; ++y) {
      const auto found = by_block.find({x, y});
      if (found == by_block.end()) continue;
      for (const std::uint32_t patch : found->second) {
        if (distance_to_block_m(surface.patches[patch].centre_m, block) <= reach_m) {
          near.push_back(patch);
        }
      }
    }
  }
  return near;
}

double half_diagonal_m(const SurfacePatch& patch) {
  return std::numbers::sqrt2 * patch.half_side_m;
}

}  // namespace

std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m) {
  const PatchesByBlock by_block = patches_by_block(surface);
  double widest_m = 0.0;
  for (const SurfacePatch& patch : surface.patches) {
    widest_m = std::max(widest_m, half_diagonal_m(patch));
  }
  std::map<TileKey, SiteBlock> blocks;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    blocks[block_key(sites.sites[i].p_map_m)].sites.push_back(i);
  }
  std::vector<SiteBlock> list;
  for (auto& [key, block] : blocks) {
    block.origin_m = {
        key.x * kSiteBlock_m, key.y * kSiteBlock_m,
        std::floor(sites.sites[block.sites[0]].p_map_m.z() / kSiteBlock_m) * kSiteBlock_m};
    block.patches = patches_near(key, by_block, surface, reach_m + widest_m);
    list.push_back(std::move(block));
  }
  return list;
}

}  // namespace sightline
