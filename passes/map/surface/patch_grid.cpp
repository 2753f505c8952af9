#include "passes/map/surface/patch_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline {
namespace {

// The cells in which points of a lattice over the patch lie, half a cell apart at most.
void cells_of(const PatchPlane& plane, double cell_m, std::vector<CellKey>& keys) {
  keys.clear();
  const int steps = static_cast<int>(std::ceil(2.0 * plane.half_side_m / cell_m));
  const double step_m = plane.half_side_m / steps;
  for (int row = -steps; row <= steps; ++row) {
    for (int column = -steps; column <= steps; ++column) {
      const Eigen::Vector3d at_m =
          plane.centre_m + step_m * (column * plane.side + row * plane.other_side);
      const CellKey key = cell_key(at_m, cell_m);
      if (keys.empty() || keys.back() != key) keys.push_back(key);
    }
  }
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace

PatchPlane::PatchPlane(const SurfacePatch& patch)
    : centre_m(patch.centre_m),
      normal(patch.normal),
      side(side_of(patch)),
      other_side(patch.normal.cross(side)),
      half_side_m(patch.half_side_m) {}

int PatchPlane::square_of(const Eigen::Vector3d& place_m) const {
  const Eigen::Vector3d from_centre_m = place_m - centre_m;
  const double along_m = side.dot(from_centre_m);
  const double across_m = other_side.dot(from_centre_m);
  if (std::abs(along_m) > half_side_m || std::abs(across_m) > half_side_m) return -1;
  return square_at(along_m / half_side_m, across_m / half_side_m);
}

Eigen::Vector3d PatchPlane::middle_m(int square) const {
  const double step_m = 2.0 * half_side_m / kPatchSquares;
  const double column = square % kPatchSquares + 0.5 - 0.5 * kPatchSquares;
  const double row = square / kPatchSquares + 0.5 - 0.5 * kPatchSquares;
  return centre_m + step_m * (column * side + row * other_side);
}

PatchGrid::PatchGrid(std::span<const SurfacePatch> patches, double cell_m) : cell_m_(cell_m) {
  std::vector<CellKey> cells;         // that patches reach, patch by patch
  std::vector<std::size_t> ends;      // of the patches in them
  std::vector<CellKey> cells_of_one;  // ascending
  planes_.reserve(patches.size());
  for (const SurfacePatch& patch : patches) {
    planes_.emplace_back(patch);
    cells_of(planes_.back(), cell_m, cells_of_one);
    cells.insert(cells.end(), cells_of_one.begin(), cells_of_one.end());
    ends.push_back(cells.size());
  }
  number_cells(cells);
  // A cell's begin stands one further on until its patches have moved it there.
  reaching_.resize(cells.size());
  std::uint32_t patch = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    while (i == ends[patch]) ++patch;
    const std::size_t number = number_in(block_at(block_of(cells[i])), bit_of(cells[i]));
    reaching_[begin_[number + 1]++] = patch;
  }
}

// Fills blocks, their cells' begins and the bounds of all.
void PatchGrid::number_cells(std::span<const CellKey> cells) {
  if (!cells.empty()) low_ = high_ = cells.front();
  for (const CellKey& cell : cells) {
    low_ = {std::min(low_.x, cell.x), std::min(low_.y, cell.y), std::min(low_.z, cell.z)};
    high_ = {std::max(high_.x, cell.x), std::max(high_.y, cell.y), std::max(high_.z, cell.z)};
    const std::uint32_t block = blocks_.insert(block_of(cell)).number;
    blocks_.values()[block].held |= bit_of(cell);
  }
  std::uint32_t count = 0;
  for (PatchBlock& block : blocks_.values()) {
    block.first_cell = count;
    count += static_cast<std::uint32_t>(std::popcount(block.held));
  }
  begin_.assign(count + 2, 0);
  for (const CellKey& cell : cells) {
    ++begin_[number_in(block_at(block_of(cell)), bit_of(cell)) + 2];
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
}

// A cell wider on all sides, which is more than rounding moves.
PatchGrid::Stretch PatchGrid::stretch_of(const Eigen::Vector3d& from_m,
                                         const Eigen::Vector3d& direction) const {
  if (blocks_.empty()) return {};
  const Eigen::Vector3d low_m = cell_m_ * Eigen::Vector3d(low_.x - 1, low_.y - 1, low_.z - 1);
  const Eigen::Vector3d high_m = cell_m_ * Eigen::Vector3d(high_.x + 2, high_.y + 2, high_.z + 2);
  Stretch stretch{0.0, std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (from_m[axis] < low_m[axis] || from_m[axis] > high_m[axis]) return {};
      continue;
    }
    const double to_low_m = (low_m[axis] - from_m[axis]) / direction[axis];
    const double to_high_m = (high_m[axis] - from_m[axis]) / direction[axis];
    stretch.enter_m = std::max(stretch.enter_m, std::min(to_low_m, to_high_m));
    stretch.leave_m = std::min(stretch.leave_m, std::max(to_low_m, to_high_m));
  }
  return stretch;
}

}  // namespace sightline
