#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/grid/flat_cell_map.h"
#include "formats/surroundings/surface.h"

namespace sightline {

inline constexpr int kSquaresOfPatch = kPatchSquares * kPatchSquares;

// A patch with its axes at hand.
struct PatchPlane {
  Eigen::Vector3d centre_m, normal, side, other_side;
  double half_side_m = 0.0;

  explicit PatchPlane(const SurfacePatch& patch);
  // The square across which a place lies; -1 beside the patch.
  [[nodiscard]] int square_of(const Eigen::Vector3d& place_m) const;
  [[nodiscard]] Eigen::Vector3d middle_m(int square) const;
};

// The cells of a block that hold patches have consecutive numbers, in the order of their bits.
struct PatchBlock {
  std::uint64_t held = 0;        // the bits of those cells
  std::uint32_t first_cell = 0;  // the number of the first one
};

// Finds the patches that reach into a cell of a grid. Most cells hold none, so that one look at a
// block of 4 x 4 x 4 of them answers for many.
class PatchGrid {
 public:
  PatchGrid(std::span<const SurfacePatch> patches, double cell_m);

  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] const PatchPlane& plane(std::uint32_t patch) const { return planes_[patch]; }
  // Ascending; none for most cells.
  [[nodiscard]] std::span<const std::uint32_t> patches_at(const CellKey& cell) const {
    return patches_at(cell, block_at(block_of(cell)));
  }

  // A stretch of a ray outside of which it meets no cell that holds a patch; no stretch where
  // enter_m > leave_m.
  struct Stretch {
    double enter_m = 0.0;
    double leave_m = -1.0;
  };
  [[nodiscard]] Stretch stretch_of(const Eigen::Vector3d& from_m,
                                   const Eigen::Vector3d& direction) const;
  // False for cells that lie beyond all that hold patches.
  [[nodiscard]] bool is_among(const CellKey& cell) const {
    return cell.x >= low_.x && cell.x <= high_.x && cell.y >= low_.y && cell.y <= high_.y &&
           cell.z >= low_.z && cell.z <= high_.z;
  }

  static CellKey block_of(const CellKey& cell) { return {cell.x >> 2, cell.y >> 2, cell.z >> 2}; }
  static std::uint64_t bit_of(const CellKey& cell) {
    return std::uint64_t{1} << ((cell.x & 3) | (cell.y & 3) << 2 | (cell.z & 3) << 4);
  }
  // Of a block, by its key: without any cell where there are no patches.
  [[nodiscard]] PatchBlock block_at(const CellKey& block) const {
    const PatchBlock* found = blocks_.find(block);
    return found == nullptr ? PatchBlock{} : *found;
  }
  // Of a cell of this block.
  [[nodiscard]] std::span<const std::uint32_t> patches_at(const CellKey& cell,
                                                          const PatchBlock& block) const {
    const std::uint64_t bit = bit_of(cell);
    if ((block.held & bit) == 0) return {};
    const std::size_t number = number_in(block, bit);
    return std::span(reaching_).subspan(begin_[number], begin_[number + 1] - begin_[number]);
  }

 private:
  static std::uint32_t number_in(const PatchBlock& block, std::uint64_t bit) {
    return block.first_cell + static_cast<std::uint32_t>(std::popcount(block.held & (bit - 1)));
  }
  void number_cells(std::span<const CellKey> cells);

  double cell_m_;
  CellKey low_{0, 0, 0}, high_{-1, -1, -1};  // of the cells that hold patches, both included
  std::vector<PatchPlane> planes_;
  FlatCellMap<PatchBlock> blocks_;
  std::vector<std::uint32_t> begin_;  // by number of the cell, into reaching_; and the end
  std::vector<std::uint32_t> reaching_;
};

}  // namespace sightline
