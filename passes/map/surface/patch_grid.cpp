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
  if (cells.empty()) return;
  find_bounds(cells);
  make_columns(cells);
  number_cells(cells);
  // A cell's begin stands one further on until its patches have moved it there.
  reaching_.resize(cells.size());
  std::uint32_t patch = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    while (i == ends[patch]) ++patch;
    const std::uint32_t number = number_of(cells[i]);
    reaching_[cells_[number + 1].begin++] = patch;
    const Heights heights = heights_in(cells[i], planes_[patch]);
    Heights& of_cell = cells_[number].heights;
    of_cell = {std::min(of_cell.low, heights.low), std::max(of_cell.high, heights.high)};
  }
  cells_.pop_back();
  lanes_ = PatchLanes(planes_, box_m());
}

void PatchGrid::find_bounds(std::span<const CellKey> cells) {
  low_ = high_ = cells.front();
  for (const CellKey& cell : cells) {
    low_ = {std::min(low_.x, cell.x), std::min(low_.y, cell.y), std::min(low_.z, cell.z)};
    high_ = {std::max(high_.x, cell.x), std::max(high_.y, cell.y), std::max(high_.z, cell.z)};
  }
}

void PatchGrid::make_columns(std::span<const CellKey> cells) {
  low_block_ = block_of(low_);
  const CellKey high_block = block_of(high_);
  size_x_ = static_cast<std::uint32_t>(high_block.x - low_block_.x + 1);
  size_y_ = static_cast<std::uint32_t>(high_block.y - low_block_.y + 1);
  columns_.assign(std::size_t{size_x_} * size_y_, {});
  const auto column_of = [&](const CellKey& block) -> Column& {
    return columns_[static_cast<std::size_t>(block.x - low_block_.x) * size_y_ +
                    static_cast<std::size_t>(block.y - low_block_.y)];
  };
  for (const CellKey& cell : cells) {
    const CellKey block = block_of(cell);
    Column& column = column_of(block);
    if (column.count == 0) column = {block.z, 1, 0};
    const std::int32_t low = std::min(column.low, block.z);
    const std::int32_t high =
        std::max(column.low + static_cast<std::int32_t>(column.count) - 1, block.z);
    column = {low, static_cast<std::uint32_t>(high - low + 1), 0};
  }
  std::uint32_t count = 0;
  for (Column& column : columns_) {
    column.first = count;
    count += column.count;
  }
  blocks_.assign(count, {});
  for (const CellKey& cell : cells) {
    const CellKey block = block_of(cell);
    const Column& column = column_of(block);
    blocks_[column.first + static_cast<std::uint32_t>(block.z - column.low)].held |= bit_of(cell);
  }
}

void PatchGrid::number_cells(std::span<const CellKey> cells) {
  std::uint32_t count = 0;
  for (PatchBlock& block : blocks_) {
    block.first_cell = count;
    count += static_cast<std::uint32_t>(std::popcount(block.held));
  }
  cells_.assign(count + 2, {0, {kHeightsOfCell, 0}});
  for (const CellKey& cell : cells) ++cells_[number_of(cell) + 2].begin;
  for (std::size_t i = 1; i < cells_.size(); ++i) cells_[i].begin += cells_[i - 1].begin;
}

// Over the square of the cell a plane rises to either side of its middle by this.
PatchGrid::Heights PatchGrid::heights_in(const CellKey& cell, const PatchPlane& plane) const {
  constexpr double kMore = 0.02;  // far more than rounding moves
  const Eigen::Vector3d to_m = cell_centre_m(cell, cell_m_) - plane.centre_m;
  const Eigen::Vector3d& normal = plane.normal;
  const double rise_m = 0.5 * cell_m_ * (std::abs(normal.x()) + std::abs(normal.y()));
  const double middle_m = -normal.dot(to_m);
  const double up = std::abs(normal.z()) * cell_m_;
  // Of an upright plane that crosses the cell neither is a number.
  const auto height_of = [&](double above_m) { return (0.5 + above_m / up) * kHeightsOfCell; };
  const double side_m = normal.z() < 0.0 ? -middle_m : middle_m;
  const double low = std::floor(height_of(side_m - rise_m) - kMore);
  const double high = std::ceil(height_of(side_m + rise_m) + kMore);
  const auto held = [](double height, double otherwise) {
    const double sure = std::isnan(height) ? otherwise : height;
    return static_cast<std::uint8_t>(std::clamp(sure, 0.0, double{kHeightsOfCell}));
  };
  return {held(low, 0.0), held(high, kHeightsOfCell)};
}

Eigen::AlignedBox3d PatchGrid::box_m() const {
  return {cell_m_ * Eigen::Vector3d(low_.x - 1, low_.y - 1, low_.z - 1),
          cell_m_ * Eigen::Vector3d(high_.x + 2, high_.y + 2, high_.z + 2)};
}

PatchGrid::Stretch PatchGrid::stretch_of(const Eigen::Vector3d& from_m,
                                         const Eigen::Vector3d& direction) const {
  if (cells_.empty()) return {};
  const Eigen::AlignedBox3d box_m = this->box_m();
  Stretch stretch{0.0, std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (from_m[axis] < box_m.min()[axis] || from_m[axis] > box_m.max()[axis]) return {};
      continue;
    }
    const double to_low_m = (box_m.min()[axis] - from_m[axis]) / direction[axis];
    const double to_high_m = (box_m.max()[axis] - from_m[axis]) / direction[axis];
    stretch.enter_m = std::max(stretch.enter_m, std::min(to_low_m, to_high_m));
    stretch.leave_m = std::min(stretch.leave_m, std::max(to_low_m, to_high_m));
  }
  return stretch;
}

}  // namespace sightline
