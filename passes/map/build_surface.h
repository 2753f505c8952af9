#pragma once

#include <vector>

#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass.h"

namespace sightline {

struct BuildSurfaceOptions {
  double cell_m = 0.5;
  double tile_m = 64.0;
  int min_points = 3;
};
std::vector<OptionField> option_fields(BuildSurfaceOptions& options);

// Square patches that rays can hit, in the frame of `points`, solid where returns lie and between
// them, open where rays of the scans went through and on (schemas/definitions.md, "Surface").
// Errors: bad-value (a tile that is no multiple of the cell), empty-map (no patch),
// invalid-artifact (a point that the grid cannot hold), disk-full or cannot-write (temporary file).
Result<TiledSurface> build_surface(PassContext& ctx, const BuildSurfaceOptions& options,
                                   const SurfacePoints& points);
inline constexpr Pass kBuildSurface =
    Pass{"build-surface", 6, "surface", "The surface for ray casting", &build_surface}
        .in(Stage::kTiles)
        .with({.million_points_s = 0.8});

}  // namespace sightline
