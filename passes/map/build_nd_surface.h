#pragma once

#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass.h"

namespace sightline {

// The surface of a map of which only NDs are left (nd_surface.h), in their cells; of a map file,
// for instance, which holds no surface. Rougher than that of points, as a warning says. Error:
// empty-map (no ND).
Result<TiledSurface> build_nd_surface(PassContext& ctx, const NoOptions& options,
                                      const NdtMap& map);
inline constexpr Pass kBuildNdSurface =
    Pass{"build-nd-surface", 2, "surface", "The surface that rays hit, of NDs alone",
         &build_nd_surface}
        .in(Stage::kTiles);

}  // namespace sightline
