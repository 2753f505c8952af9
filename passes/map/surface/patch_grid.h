#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/grid/cell_key.h"
#include "formats/surroundings/surface.h"
#include "passes/map/surface/patch_lanes.h"

namespace sightline {

// The cells of a block that hold patches have consecutive numbers, in the order of their bits.
struct PatchBlock {
  std::uint64_t held = 0;        // the bits of those cells
  std::uint32_t first_cell = 0;  // the number of the first one
};

// Finds the patches that reach into a cell of a grid, by blocks of 4 x 4 x 4 cells. Takes memory
// for all blocks of the plane between patches, and in each of its columns for those between the
// lowest and the highest patch: for patches of one place.
class PatchGrid {
 public:
  PatchGrid(std::span<const SurfacePatch> patches, double cell_m);

  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] const PatchPlane& plane(std::uint32_t patch) const { return planes_[patch]; }
  // Of the same patches, for places in cells that hold patches.
  [[nodiscard]] const PatchLanes& lanes() const { return lanes_; }
  // Ascending; none for most cells.
  [[nodiscard]] std::span<const std::uint32_t> patches_at(const CellKey& cell) const {
    const std::uint32_t number = number_of(cell);
    return number == kNone ? std::span<const std::uint32_t>() : patches_of(number);
  }

  // Cells that hold patches are numbered 0, 1, 2, ...
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  [[nodiscard]] std::size_t cell_count() const { return cells_.empty() ? 0 : cells_.size() - 1; }
  // kNone for a cell that holds none.
  [[nodiscard]] std::uint32_t number_of(const CellKey& cell) const {
    const PatchBlock block = block_at(block_of(cell));
    const std::uint64_t bit = bit_of(cell);
    return (block.held & bit) == 0 ? kNone : number_in(block, bit);
  }
  // Ascending.
  [[nodiscard]] std::span<const std::uint32_t> patches_of(std::uint32_t number) const {
    return std::span(reaching_).subspan(cells_[number].begin,
                                        cells_[number + 1].begin - cells_[number].begin);
  }

  // The heights of a cell, from its bottom to its top, in which planes of its patches lie there:
  // those of at least one patch, and maybe some around.
  static constexpr int kHeightsOfCell = 255;
  struct Heights {
    std::uint8_t low = 0;
    std::uint8_t high = 0;
  };
  [[nodiscard]] Heights heights_of(std::uint32_t number) const { return cells_[number].heights; }

  // Of the cells that hold patches, and a cell around them, which is more than rounding moves.
  [[nodiscard]] Eigen::AlignedBox3d box_m() const;
  // A stretch of a ray outside of which it meets no cell that holds a patch; no stretch where
  // enter_m > leave_m.
  struct Stretch {
    double enter_m = 0.0;
    double leave_m = -1.0;
  };
  [[nodiscard]] Stretch stretch_of(const Eigen::Vector3d& from_m,
                                   const Eigen::Vector3d& direction) const;

  static constexpr std::int32_t kBlock_cells = 4;  // along an edge
  static CellKey block_of(const CellKey& cell) { return {cell.x >> 2, cell.y >> 2, cell.z >> 2}; }
  static std::uint64_t bit_of(const CellKey& cell) {
    return std::uint64_t{1} << ((cell.x & 3) | (cell.y & 3) << 2 | (cell.z & 3) << 4);
  }
  // Of a block, by its key: without any cell where there are no patches.
  [[nodiscard]] PatchBlock block_at(const CellKey& block) const {
    const Column* column = column_at(block);
    if (column == nullptr) return {};
    const auto up = static_cast<std::uint32_t>(block.z - column->low);
    return up < column->count ? blocks_[column->first + up] : PatchBlock{};
  }
  // Of a cell that this block holds, by its bit.
  static std::uint32_t number_in(const PatchBlock& block, std::uint64_t bit) {
    return block.first_cell + static_cast<std::uint32_t>(std::popcount(block.held & (bit - 1)));
  }

 private:
  // Blocks above one another.
  struct Column {
    std::int32_t low = 0;  // z of the lowest
    std::uint32_t count = 0;
    std::uint32_t first = 0;  // its position among all blocks
  };
  struct Cell {
    std::uint32_t begin = 0;  // in reaching_
    Heights heights;
  };

  [[nodiscard]] const Column* column_at(const CellKey& block) const {
    const auto x = static_cast<std::uint32_t>(block.x - low_block_.x);
    const auto y = static_cast<std::uint32_t>(block.y - low_block_.y);
    return x < size_x_ && y < size_y_ ? &columns_[std::size_t{x} * size_y_ + y] : nullptr;
  }
  void find_bounds(std::span<const CellKey> cells);
  void make_columns(std::span<const CellKey> cells);
  void number_cells(std::span<const CellKey> cells);
  [[nodiscard]] Heights heights_in(const CellKey& cell, const PatchPlane& plane) const;

  double cell_m_;
  CellKey low_{0, 0, 0}, high_{-1, -1, -1};  // of the cells that hold patches, both included
  std::vector<PatchPlane> planes_;
  PatchLanes lanes_;
  CellKey low_block_{0, 0, 0};
  std::uint32_t size_x_ = 0, size_y_ = 0;  // in blocks
  std::vector<Column> columns_;
  std::vector<PatchBlock> blocks_;
  std::vector<Cell> cells_;  // and the end of the last one
  std::vector<std::uint32_t> reaching_;
};

struct FollowedRay {
  Eigen::Vector3d from_m, direction;
  double range_m = 0.0;
  PatchLanes::Ray lanes;
};

// A cell in which a ray may cross a patch, and from where to where it lies there, with its slack.
struct RayVisit {
  std::uint32_t cell = 0;  // its number in the grid
  std::uint32_t ray = 0;   // its position among the rays
  float enter_m = 0.0F;
  float leave_m = 0.0F;
};

struct FollowedRays {
  std::vector<FollowedRay> rays;  // with visits
  std::vector<RayVisit> visits;   // in the order of rays
};

// How far a ray of a scan is followed at most, m.
inline constexpr double kLongestPass_m = 60.0;

// Adds the ray of a return, with each cell of the grid in which square_passed() may find anything.
void follow_ray(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, const PatchGrid& grid,
                FollowedRays& followed);

// The square of the patch through which a ray went and on, if it crosses the patch in this cell,
// which it visits; otherwise -1.
int square_passed(const FollowedRay& ray, std::uint32_t patch, std::uint32_t cell,
                  const PatchGrid& grid);

}  // namespace sightline
