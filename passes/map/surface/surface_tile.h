#pragma once

#include <vector>

#include "formats/base/result.h"
#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"
#include "passes/map/tiles/build_ndt_cells.h"
#include "passes/map/tiles/cell_tiles.h"

namespace sightline {

struct SurfaceTileOptions {
  double cell_m = 0.5;
  double tile_m = 64.0;  // by which patches are ordered
  int min_points = 3;
  double returns_per_ray = 1.0;  // of all scans, in sixteenths
};

// What one tile gives of a surface.
struct SurfaceTile {
  CellTally cells;                    // of at least two points
  std::vector<SurfacePatch> patches;  // ascending by order_of()
};
SIGHTLINE_FIELDS(SurfaceTile, cells, patches)

// The patches whose centres lie over a tile, but for ground between ground: those of the surface of
// all scans, to the bit. `tiles`: of cells of the options, blocks a multiple of kLongestCell_cells.
// As many scans in memory as threads (0: all there are). Errors: what reading a scan says.
// What decides it (PartedWork::content): content_of_tile().
Result<SurfaceTile> surface_of_tile(const SurfacePoints& points, const SurfaceTileOptions& options,
                                    const CellTiles& tiles, std::size_t tile, int threads);

std::optional<Digest> content_of_tile(const SurfacePoints& points,
                                      const SurfaceTileOptions& options, const CellTiles& tiles,
                                      std::size_t tile);

}  // namespace sightline
