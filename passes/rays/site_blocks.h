#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/surroundings/surface.h"

namespace sightline {

inline constexpr double kSiteBlock_m = 64.0;  // edge of a square

// Sites that share one scene: those in one square of the plane, and the patches that their rays can
// reach. Squares are fixed, so that no result depends on how a map is cut into tiles.
struct SiteBlock {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // a corner of the square
  std::vector<std::size_t> sites;                      // ascending
  std::vector<std::uint32_t> patches;                  // in an order that no tiling changes
};
std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m);

}  // namespace sightline
