#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "compiler/pipeline/pass_context.h"
#include "formats/sites.h"
#include "formats/surface.h"

// Where rays meet a surface. The home of Embree: nothing else in passes/ knows it.

namespace sightline {

// Directions of unit length in map axes; neighbours in the list should be neighbours in the world,
// because eight rays at a time go through the scene together.
struct RayFan {
  std::vector<Eigen::Vector3d> directions;
  double near_m = 0.5;
  double far_m = 50.0;
};

// distance_m[i] belongs to directions[i]: to the first hit between near_m and far_m, +inf where
// there is none.
using TakeDistances = std::function<void(std::size_t site, std::span<const double> distance_m)>;

// Casts one fan from the p of every site and hands over the distances, site by site; sites of one
// block of the plane side by side on ctx.threads threads, so `take` may write only what is that
// site's. Both faces of a patch count. Embree finds the patch in float; the distance to the patch's
// plane is computed in double. Reports progress. One scene at a time is in memory.
// Error: mismatched-inputs where surface and sites lie in different frames.
Result<void> cast_at_sites(PassContext& ctx, const Surface& surface, const Sites& sites,
                           const RayFan& fan, const TakeDistances& take);

// Sites that share one scene: those in one square of the plane, and the patches that their rays can
// reach. Squares are fixed (64 m), so that no result depends on how a map is cut into tiles.
struct SiteBlock {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // a corner of the square
  std::vector<std::size_t> sites;                      // ascending
  std::vector<std::uint32_t> patches;                  // in an order that no tiling changes
};
std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m);

}  // namespace sightline
