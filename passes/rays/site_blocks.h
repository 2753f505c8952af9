#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/surface.h"

namespace sightline {

inline constexpr double kSiteBlock_m = 64.0;  // edge of a square

// Sites that share one scene: those in one square of the plane. Squares are fixed, so that no
// result depends on how a map is cut into tiles.
struct SiteBlock {
  TileKey key;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // a corner of the square
  std::vector<std::size_t> sites;                      // ascending
};
std::vector<SiteBlock> blocks_of_sites(const Sites& sites);

// The block and what lies around it in the plane.
Eigen::AlignedBox2d box_around(const SiteBlock& block, double reach_m);

// The patches with centres at most that far from the square, in an order that no tiling changes.
std::vector<SurfacePatch> patches_near(const SiteBlock& block, const Surface& surface,
                                       double reach_m);

}  // namespace sightline
