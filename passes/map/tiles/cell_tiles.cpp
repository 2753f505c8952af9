#include "passes/map/tiles/cell_tiles.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace sightline {
namespace {

// Sensors see 100 m around: smaller ones would open each scan more often, larger ones take more
// memory (a street of 16 beams about 0.4 MiB for each of its metres in the tile).
constexpr double kLeastTile_m = 256.0;
constexpr std::int32_t kBlocks = 8;  // along the edge of a tile

TileKey divided(const TileKey& key, std::int32_t divisor) {
  return {floor_divide(key.x, divisor), floor_divide(key.y, divisor)};
}

// The frame begins where a drive does: the middle of a tile lies there, so that a street along an
// axis is not cut lengthwise.
TileKey tile_of_block(const TileKey& block) {
  return divided({block.x + kBlocks / 2, block.y + kBlocks / 2}, kBlocks);
}

bool is_over(const ScanExtent& extent, const CellBox& blocks) {
  // Ascending by x: what lies before the box is left out at once.
  auto block = std::ranges::lower_bound(extent.blocks, TileKey{blocks.low.x, blocks.low.y});
  for (; block != extent.blocks.end() && block->x <= blocks.high.x; ++block) {
    if (block->y >= blocks.low.y && block->y <= blocks.high.y) return true;
  }
  return false;
}

}  // namespace

Eigen::AlignedBox2d extent_m(const CellBox& box, double cell_m) {
  return {Eigen::Vector2d(box.low.x, box.low.y) * cell_m,
          Eigen::Vector2d(box.high.x + 1.0, box.high.y + 1.0) * cell_m};
}

CellBox with_halo(const CellBox& box, std::int32_t halo_cells) {
  return {{box.low.x - halo_cells, box.low.y - halo_cells},
          {box.high.x + halo_cells, box.high.y + halo_cells}};
}

BlockGrid blocks_of_tiles(double cell_m, std::int32_t step_cells) {
  const double steps = std::ceil(kLeastTile_m / kBlocks / (step_cells * cell_m));
  return {cell_m, step_cells * static_cast<std::int32_t>(steps)};
}

CellTiles::CellTiles(std::vector<ScanExtent> extents, const BlockGrid& grid)
    : extents_(std::move(extents)), grid_(grid) {
  std::set<TileKey> tiles;
  for (const ScanExtent& extent : extents_) {
    for (const TileKey& block : extent.blocks) tiles.insert(tile_of_block(block));
  }
  tiles_.assign(tiles.begin(), tiles.end());
}

CellBox CellTiles::box(std::size_t tile) const {
  const auto first = [&](std::int32_t key) {
    return (key * kBlocks - kBlocks / 2) * grid_.block_cells;
  };
  const std::int32_t cells = kBlocks * grid_.block_cells;
  const TileKey low{first(tiles_[tile].x), first(tiles_[tile].y)};
  return {low, {low.x + cells - 1, low.y + cells - 1}};
}

std::vector<std::size_t> CellTiles::parts_over(const CellBox& cells) const {
  const CellBox blocks{divided(cells.low, grid_.block_cells),
                       divided(cells.high, grid_.block_cells)};
  std::vector<std::size_t> parts;
  for (std::size_t part = 0; part < extents_.size(); ++part) {
    if (is_over(extents_[part], blocks)) parts.push_back(part);
  }
  return parts;
}

}  // namespace sightline
