#pragma once

#include "passes/matching/match_grid.h"

namespace sightline {

// Index of the valid ND of a cell, or MatchGrid::kNone. Its neighbours do not count here.
inline std::int32_t nd_of_cell(const MatchGrid& grid, const CellKey& key) {
  const std::int32_t cell = find_cell(grid, key);
  if (cell == MatchGrid::kNone) return MatchGrid::kNone;
  return grid.neighbourhoods[static_cast<std::size_t>(cell)][0];
}

}  // namespace sightline
