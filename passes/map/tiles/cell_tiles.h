#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/grid/cell_key.h"
#include "passes/map/tiles/scan_extents.h"

// Tiles of whole cells, and which parts of surface points reach them: a pass that goes tile by tile
// needs memory for one, however long the street is.

namespace sightline {

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

}  // namespace sightline
