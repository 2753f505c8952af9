#pragma once

#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass.h"

namespace sightline {

// A patch for each ND, flat at right angles to its shortest axis, solid as far as evenly spread
// points with the ND's variances reach (sqrt(3) sigma along each of the other axes). Of NDs of
// class 3, which are leaves and clutter, every other square is open.
Surface surface_of_nds(const NdtMap& map);

// The surface of a map of which only NDs are left, as in a map file. Rougher than that of points,
// as a warning says. Error: empty-map (no ND).
Result<TiledSurface> build_nd_surface(PassContext& ctx, const NoOptions& options,
                                      const NdtMap& map);
inline constexpr Pass kBuildNdSurface =
    Pass{"build-nd-surface", 2, "surface", "The surface for ray casting, from NDs",
         &build_nd_surface}
        .in(Stage::kTiles);

}  // namespace sightline
