#include "passes/map/surface/patch_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

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

// A ray goes through a patch when it ends behind it by more than noise, relief and unevenness
// within a cell explain.
constexpr double kLeastBehindPlane_m = 0.2;
constexpr double kLeastBeyond_m = 0.4;  // along the ray

// From cell to cell along a ray (Amanatides and Woo, 1987), the same cells wherever it begins.
class CellWalk {
 public:
  CellWalk(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction, double cell_m)
      : CellWalk(from_m, direction, cell_m, cell_key(from_m, cell_m)) {}

  [[nodiscard]] CellKey cell() const { return {x_.at, y_.at, z_.at}; }
  [[nodiscard]] double entered_m() const { return entered_m_; }
  [[nodiscard]] double leave_m() const {
    return std::min(x_.next_m, std::min(y_.next_m, z_.next_m));
  }
  // Where it leaves the block of the cell, but for rounding.
  [[nodiscard]] double leave_block_m() const {
    return std::min(x_.leave_block_m(), std::min(y_.leave_block_m(), z_.leave_block_m()));
  }

  // Through the nearest face, of equals the first axis'.
  void go_on() {
    const bool is_x = (x_.next_m <= y_.next_m) & (x_.next_m <= z_.next_m);
    const bool is_y = !is_x & (y_.next_m <= z_.next_m);
    const bool is_z = !is_x & !is_y;
    entered_m_ = std::min(x_.next_m, std::min(y_.next_m, z_.next_m));
    x_.go_on_if(is_x);
    y_.go_on_if(is_y);
    z_.go_on_if(is_z);
  }

  // Goes on, at least once, to the first cell that is entered at a distance or beyond.
  void skip_to(double distance_m) {
    x_.skip_to(distance_m);
    y_.skip_to(distance_m);
    z_.skip_to(distance_m);
    go_on();
  }

 private:
  struct Axis {
    double next_m = std::numeric_limits<double>::infinity();  // to the next face
    double step_m = 1e300;
    std::int32_t step = 1;
    std::int32_t at = 0;

    // Without a branch, which would be guessed wrong every other time.
    void go_on_if(bool goes) {
      const std::uint64_t all = goes ? ~std::uint64_t{0} : 0;
      next_m += std::bit_cast<double>(std::bit_cast<std::uint64_t>(step_m) & all);
      at += step & static_cast<std::int32_t>(all);
    }
    Axis(double from_m, double along, double cell_m, std::int32_t begin)
        : step(along > 0.0 ? 1 : -1), at(begin) {
      if (along == 0.0) return;
      step_m = cell_m / std::abs(along);
      next_m = ((at + (along > 0.0 ? 1 : 0)) * cell_m - from_m) / along;
    }
    [[nodiscard]] double leave_block_m() const {
      constexpr std::int32_t kLast = PatchGrid::kBlock_cells - 1;
      return next_m + ((step > 0 ? ~at : at) & kLast) * step_m;
    }
    void skip_to(double distance_m) {
      for (; next_m < distance_m; next_m += step_m) at += step;
    }
  };

  CellWalk(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction, double cell_m,
           const CellKey& begin)
      : x_(from_m.x(), direction.x(), cell_m, begin.x),
        y_(from_m.y(), direction.y(), cell_m, begin.y),
        z_(from_m.z(), direction.z(), cell_m, begin.z) {}

  double entered_m_ = 0.0;
  Axis x_, y_, z_;
};

// Along an axis on which a ray hardly moves, rounding decides where it changes cells.
bool hardly_moves(const Eigen::Vector3d& direction) {
  constexpr double kLeastAlong = 1e-4;
  return std::ranges::any_of(
      direction, [](double along) { return along != 0.0 && std::abs(along) < kLeastAlong; });
}

// The bits of the cells of a block in the layers between two heights, in units of those of cells.
std::uint64_t layers_between(double one, double other) {
  constexpr double kPerHeight = 1.0 / PatchGrid::kHeightsOfCell;
  constexpr int kCellsOfLayer = PatchGrid::kBlock_cells * PatchGrid::kBlock_cells;
  constexpr double kSlack = 1e-3;  // more than rounding moves
  const auto layer_of = [](double cells) {
    return std::clamp(static_cast<int>(cells), 0, PatchGrid::kBlock_cells - 1);
  };
  const int low = layer_of(std::min(one, other) * kPerHeight - kSlack);
  const int high = layer_of(std::max(one, other) * kPerHeight + kSlack);
  const std::uint64_t all = ~std::uint64_t{0};
  return all << kCellsOfLayer * low & all >> kCellsOfLayer * (PatchGrid::kBlock_cells - 1 - high);
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

// Each patch counts in the cell in which the ray crosses it.
int square_passed(const FollowedRay& ray, std::uint32_t patch, std::uint32_t cell,
                  const PatchGrid& grid) {
  const PatchPlane& plane = grid.plane(patch);
  const double slope = plane.normal.dot(ray.direction);
  if (std::abs(slope) < kLeastSlope) return -1;
  const double distance_m = plane.normal.dot(plane.centre_m - ray.from_m) / slope;
  const double beyond_m = ray.range_m - distance_m;
  if (!(distance_m > 0.0 && beyond_m > kLeastBeyond_m)) return -1;
  if (beyond_m * std::abs(slope) < kLeastBehindPlane_m) return -1;
  const Eigen::Vector3d at_m = ray.from_m + distance_m * ray.direction;
  if (grid.number_of(cell_key(at_m, grid.cell_m())) != cell) return -1;
  return plane.square_of(at_m);
}

void follow_ray(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, const PatchGrid& grid,
                FollowedRays& followed) {
  constexpr double kHeights = PatchGrid::kHeightsOfCell;
  constexpr double kSlack_m = 1e-9;  // more than rounding moves
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double range_m = (to_m - from_m).norm();
  const Eigen::Vector3d direction = (to_m - from_m) / range_m;
  const PatchGrid::Stretch stretch = grid.stretch_of(from_m, direction);
  const double last_m = std::min({range_m - kLeastBeyond_m, kLongestPass_m, stretch.leave_m});
  if (!(stretch.enter_m < last_m)) return;
  const PatchLanes::Ray in_lanes = grid.lanes().ray_of(from_m, direction, range_m);
  const auto ray = static_cast<std::uint32_t>(followed.rays.size());
  // More than rounding moves.
  const double more_m = hardly_moves(direction) ? kInfinity : in_lanes.slack_m;
  const double more_heights = hardly_moves(direction) ? kInfinity : 0.01;
  const double from_height = kHeights * (from_m.z() / grid.cell_m());
  const double heights_per_m = kHeights * (direction.z() / grid.cell_m());
  CellWalk walk(from_m, direction, grid.cell_m());
  if (stretch.enter_m > 0.0) walk.skip_to(stretch.enter_m);
  while (walk.entered_m() < last_m) {
    const CellKey key = PatchGrid::block_of(walk.cell());
    const PatchBlock block = grid.block_at(key);
    const double leave_m = walk.leave_block_m();
    const double bottom = from_height - kHeights * PatchGrid::kBlock_cells * key.z;
    const double in = bottom + heights_per_m * walk.entered_m();
    const double out = bottom + heights_per_m * std::min(leave_m, last_m);
    if ((block.held & layers_between(in, out)) == 0) {
      walk.skip_to(leave_m - kSlack_m);
      continue;
    }
    for (; walk.entered_m() < last_m; walk.go_on()) {
      const CellKey cell = walk.cell();
      if (PatchGrid::block_of(cell) != key) break;
      const std::uint64_t bit = PatchGrid::bit_of(cell);
      if ((block.held & bit) == 0) continue;
      const std::uint32_t number = PatchGrid::number_in(block, bit);
      const PatchGrid::Heights held = grid.heights_of(number);
      const double floor = from_height - kHeights * cell.z;
      const auto [low, high] = std::minmax(
          {floor + heights_per_m * walk.entered_m(), floor + heights_per_m * walk.leave_m()});
      if (std::max(held.low - high, low - held.high) > more_heights) continue;
      followed.visits.push_back({number, ray, static_cast<float>(walk.entered_m() - more_m),
                                 static_cast<float>(walk.leave_m() + more_m)});
    }
  }
  const bool has_visits = !followed.visits.empty() && followed.visits.back().ray == ray;
  if (has_visits) followed.rays.push_back({from_m, direction, range_m, in_lanes});
}

}  // namespace sightline
