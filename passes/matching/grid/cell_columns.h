#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/grid/cell_key.h"
#include "passes/matching/kernel/match_kernel.h"

namespace sightline {

// Where the cells of a grid are, column by column of a rectangle around them. Finds a cell without
// comparing keys and is much smaller than a CellIndex, so that it stays in the caches.
class CellColumns {
 public:
  CellColumns() = default;
  // Of different cells, which are numbered in this order. Empty where the rectangle would hold more
  // than eight columns for each cell, or a column reaches too high for its numbers.
  explicit CellColumns(std::span<const CellKey> keys);

  [[nodiscard]] bool is_empty() const { return columns_.empty(); }
  // The record of a cell is the one behind its number; 0 for a cell that is not there.
  [[nodiscard]] KernelColumns records() const {
    return {columns_.data(), records_.data(), low_x_, low_y_, size_x_, size_y_};
  }

 private:
  std::vector<KernelColumn> columns_;   // row by row of y
  std::vector<std::int32_t> records_;   // of all columns, each from its lowest cell upwards
  std::int32_t low_x_ = 0, low_y_ = 0;  // of the rectangle, cells
  std::uint32_t size_x_ = 0, size_y_ = 0;
};

}  // namespace sightline
