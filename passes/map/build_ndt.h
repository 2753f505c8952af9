#pragma once

#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass.h"

namespace sightline {

struct BuildNdtOptions {
  double cell_m = 2.0;
  double tile_m = 64.0;
  int min_points = 10;
};
std::vector<OptionField> option_fields(BuildNdtOptions& options);

// The normal distributions of what stood still (schemas/definitions.md, "NDT map", v1), in the
// frame of `points`. Cells with too few points or no extent are counted in a warning. Errors:
// bad-value (a tile that is no multiple of the cell), empty-map (no valid cell), invalid-artifact
// (a point that is not finite or lies beyond the grid), disk-full or cannot-write (temporary file).
Result<TiledNds> build_ndt(PassContext& ctx, const BuildNdtOptions& options,
                           const SurfacePoints& points);
inline constexpr Pass kBuildNdt = Pass{"build-ndt", 2, "nds", "NDT map", &build_ndt}
                                      .in(Stage::kTiles)
                                      .with({.million_points_s = 0.06});

// The NDs of plain points, which must be finite and within 2^30 cells of the origin; the options
// are a tiling. The order of points decides the last bits, the number of threads (0: all) does not.
NdtMap ndt_from_points(std::span<const Eigen::Vector3d> points_m, const MapFrame& frame,
                       const BuildNdtOptions& options, int threads);

}  // namespace sightline
