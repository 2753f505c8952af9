#include "passes/map/surface/followed_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

// Rays are followed from cell to cell (Amanatides and Woo, 1987).

namespace sightline {
namespace {

// A ray goes through a patch when it ends behind it by more than noise, relief and unevenness
// within a cell explain.
constexpr double kLeastBehindPlane_m = 0.2;
constexpr double kLeastBeyond_m = 0.4;  // along the ray

// From cell to cell along a ray. Each axis has its own sum of steps, from the sensor on, so that
// the cells are the same wherever one begins to look.
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

// Along an axis on which a ray hardly moves, rounding decides where it changes cells: then nothing
// can say beforehand how long it is in one.
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
