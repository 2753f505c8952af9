#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/grid/cell_index.h"

namespace sightline {

// A set of cells that is mostly asked for others: one bit, which the cache holds, answers for 15 of
// 16 of these that they are not there, where a look into a table waits for memory. Safe to ask from
// several threads.
class CellSet {
 public:
  explicit CellSet(std::span<const CellKey> cells)
      : bits_(std::bit_ceil(kBitsPerCell * (cells.size() + 4)) / 64) {
    for (const CellKey& cell : cells) {
      index_.add(cell);
      bits_[word_of(cell)] |= bit_of(cell);
    }
  }

  [[nodiscard]] bool contains(const CellKey& cell) const {
    return (bits_[word_of(cell)] & bit_of(cell)) != 0 && index_.find(cell) != CellIndex::kNone;
  }
  [[nodiscard]] bool empty() const { return index_.size() == 0; }

 private:
  static constexpr std::size_t kBitsPerCell = 16;

  [[nodiscard]] std::size_t word_of(const CellKey& cell) const {
    return (hash_of(cell) >> 6) & (bits_.size() - 1);
  }
  static std::uint64_t bit_of(const CellKey& cell) {
    return std::uint64_t{1} << (hash_of(cell) & 63);
  }

  std::vector<std::uint64_t> bits_;  // a power of two of words
  CellIndex index_;
};

}  // namespace sightline
