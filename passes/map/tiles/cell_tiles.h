#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/surface_points.h"
#include "passes/map/tiles/build_ndt_cells.h"
#include "passes/pass/pass_context.h"

// Tiles of whole cells, and which parts of surface points reach them.

namespace sightline {

// The extent of one part of surface points (SurfacePointReader): of all points within range, moving
// or not, so that a further drive does not change it.
struct ScanExtent {
  std::uint64_t point_count = 0;
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();  // box of the points, map frame
  Eigen::Vector2d high_m = Eigen::Vector2d::Zero();
  std::vector<TileKey> blocks;  // that hold one of them, ascending
};
SIGHTLINE_FIELDS(ScanExtent, point_count, low_m, high_m, blocks)

// Square columns of whole cells, the unit of extents.
struct BlockGrid {
  double cell_m = 0.0;
  std::int32_t block_cells = 1;
};

// Of each part, in their order. These are the first parts of the work of `pass`; then see
// after_extents(). Errors: those of reading; invalid-artifact (a point that is not finite or more
// than 2^30 cells from the origin).
Result<std::vector<ScanExtent>> measure_extents(const PassContext& ctx, const SurfacePoints& points,
                                                const BlockGrid& grid, const std::string& pass);

// The context for later parts of the pass: their numbers begin after those of measure_extents().
PassContext after_extents(const PassContext& ctx, const SurfacePoints& points);

// Columns of cells of all heights: x and y of their keys from low to high, both included.
struct CellBox {
  TileKey low, high;
  [[nodiscard]] bool holds(const CellKey& key) const {
    return key.x >= low.x && key.x <= high.x && key.y >= low.y && key.y <= high.y;
  }
  [[nodiscard]] bool meets(const CellBox& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y;
  }
};
SIGHTLINE_FIELDS(CellBox, low, high)
// In the plane of the map.
Eigen::AlignedBox2d extent_m(const CellBox& box, double cell_m);
CellBox with_halo(const CellBox& box, std::int32_t halo_cells);

// Of tiles with edges of at least 256 m, whose blocks are a multiple of `step_cells` cells.
BlockGrid blocks_of_tiles(double cell_m, std::int32_t step_cells = 1);

// The square tiles over which something stands.
class CellTiles {
 public:
  // The extents are in units of the blocks of the grid.
  CellTiles(std::vector<ScanExtent> extents, const BlockGrid& grid);

  [[nodiscard]] std::size_t size() const { return tiles_.size(); }
  [[nodiscard]] CellBox box(std::size_t tile) const;
  // The parts of surface points that have points over these cells, and maybe some that have them
  // beside; ascending.
  [[nodiscard]] std::vector<std::size_t> parts_over(const CellBox& cells) const;
  // By part.
  [[nodiscard]] const std::vector<ScanExtent>& extents() const { return extents_; }

 private:
  std::vector<ScanExtent> extents_;
  BlockGrid grid_;
  std::vector<TileKey> tiles_;  // ascending
};

// The cells of a box with the points of these parts, added in the order of parts and of points. As
// many parts in memory as threads (0: all there are). Errors: those of reading a scan.
Result<NdtCells> cells_over(const SurfacePointReader& reader, std::span<const std::size_t> parts,
                            const CellBox& box, double cell_m, int threads);

}  // namespace sightline
