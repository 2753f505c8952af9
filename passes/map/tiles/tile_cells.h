#pragma once

#include <span>

#include "formats/base/result.h"
#include "formats/surroundings/surface_points.h"
#include "passes/map/tiles/build_ndt_cells.h"
#include "passes/map/tiles/cell_tiles.h"

namespace sightline {

// The cells of a box with the points of these parts that lie over it, added in the order of parts
// and of points: each cell is that of all parts, to the bit. As many parts in memory as threads (0:
// all there are). Errors: what reading a scan says.
Result<NdtCells> cells_over(const SurfacePointReader& reader, std::span<const std::size_t> parts,
                            const CellBox& box, double cell_m, int threads);

}  // namespace sightline
