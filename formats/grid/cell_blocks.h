#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/grid/cell_index.h"

// Cells side by side with those around them: who asks for many neighbours of each of many cells
// finds a block of cells once, where a look into a table of cells would find one neighbour.

namespace sightline {

// Cells sorted into blocks of 8 x 8 x 8.
class CellBlocks {
 public:
  static constexpr std::int32_t kEdge_cells = 8;
  struct Cell {
    CellKey key;
    std::uint32_t number = 0;  // its position among all
  };

  // Each cell once.
  explicit CellBlocks(std::span<const CellKey> cells) {
    std::vector<std::uint32_t> block_of(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) block_of[i] = blocks_.add(block(cells[i]));
    begin_.assign(blocks_.size() + 2, 0);
    // A block's begin stands one further on until its cells have moved it there.
    for (const std::uint32_t block : block_of) ++begin_[block + 2];
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    cells_.resize(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      cells_[begin_[block_of[i] + 1]++] = {cells[i], static_cast<std::uint32_t>(i)};
    }
  }

  // Blocks that hold cells, and the cells of one, in the order of their numbers.
  [[nodiscard]] std::size_t size() const { return blocks_.size(); }
  [[nodiscard]] const CellKey& key(std::size_t block) const { return blocks_.keys()[block]; }
  [[nodiscard]] std::span<const Cell> cells(std::size_t block) const {
    return std::span(cells_).subspan(begin_[block], begin_[block + 1] - begin_[block]);
  }
  // Of a block by its key: none where there is no such block.
  [[nodiscard]] std::span<const Cell> cells_at(const CellKey& key) const {
    const std::uint32_t block = blocks_.find(key);
    return block == CellIndex::kNone ? std::span<const Cell>() : cells(block);
  }

  // The block in which a cell lies.
  static CellKey block(const CellKey& cell) { return {cell.x >> 3, cell.y >> 3, cell.z >> 3}; }

 private:
  CellIndex blocks_;
  std::vector<std::uint32_t> begin_;  // of each block in cells_, and the end of the last
  std::vector<Cell> cells_;
};

// The cells of one block after another, and those around it as far as is asked for.
class CellWindow {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // Keeps a reference. So many cells beyond the block: towards lower keys, and towards higher ones.
  CellWindow(const CellBlocks& blocks, const CellKey& below, const CellKey& above)
      : blocks_(blocks),
        below_(below),
        size_{below.x + CellBlocks::kEdge_cells + above.x,
              below.y + CellBlocks::kEdge_cells + above.y,
              below.z + CellBlocks::kEdge_cells + above.z},
        numbers_(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                 static_cast<std::size_t>(size_.z)) {}

  void move_to(std::size_t block) {
    const CellKey& key = blocks_.key(block);
    low_ = {(key.x << 3) - below_.x, (key.y << 3) - below_.y, (key.z << 3) - below_.z};
    std::ranges::fill(numbers_, kNone);
    const CellKey first = CellBlocks::block(low_);
    const CellKey last =
        CellBlocks::block({low_.x + size_.x - 1, low_.y + size_.y - 1, low_.z + size_.z - 1});
    for (std::int32_t x = first.x; x <= last.x; ++x) {
      for (std::int32_t y = first.y; y <= last.y; ++y) {
        for (std::int32_t z = first.z; z <= last.z; ++z) add(blocks_.cells_at({x, y, z}));
      }
    }
  }

  // Of a cell within the window; kNone where it is not there.
  [[nodiscard]] std::uint32_t number_of(const CellKey& cell) const {
    return numbers_[place_of(cell)];
  }
  [[nodiscard]] bool holds(const CellKey& cell) const { return number_of(cell) != kNone; }

 private:
  [[nodiscard]] std::size_t place_of(const CellKey& cell) const {
    return static_cast<std::size_t>(((cell.x - low_.x) * size_.y + cell.y - low_.y) * size_.z +
                                    cell.z - low_.z);
  }
  [[nodiscard]] bool is_within(const CellKey& cell) const {
    return cell.x >= low_.x && cell.x < low_.x + size_.x && cell.y >= low_.y &&
           cell.y < low_.y + size_.y && cell.z >= low_.z && cell.z < low_.z + size_.z;
  }
  void add(std::span<const CellBlocks::Cell> cells) {
    for (const CellBlocks::Cell& cell : cells) {
      if (is_within(cell.key)) numbers_[place_of(cell.key)] = cell.number;
    }
  }

  const CellBlocks& blocks_;
  CellKey below_;
  CellKey size_;
  CellKey low_;
  std::vector<std::uint32_t> numbers_;  // of all cells of the window
};

}  // namespace sightline
