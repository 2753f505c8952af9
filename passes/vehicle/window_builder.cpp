#include "passes/vehicle/window_builder.h"

#include <algorithm>
#include <limits>
#include <utility>

// Why a window gives the same bits as the whole map: a match reads the records of the cells in
// which its points are, the cells beside these and, of an upright line, those around it. Cells of a
// coarse level are pooled from cells inside them. All of them are within match_reach_m() of the
// start, and their NDs come in the order of the map.

namespace sightline {
namespace {

// Calls visit(number) for the tiles that meet the circle, ascending, until it returns false.
template <class Visit>
void for_tiles(const MapTiles& map, const MapCircle& circle, const Visit& visit) {
  const double tile_m = map.head().ndt.tile_m;
  const auto tile_at = [&](double along_m) { return floor_to_int(along_m / tile_m); };
  const Eigen::Vector2d low_m = circle.centre_m - Eigen::Vector2d::Constant(circle.radius_m);
  const Eigen::Vector2d high_m = circle.centre_m + Eigen::Vector2d::Constant(circle.radius_m);
  const TileKey low{tile_at(low_m.x()), tile_at(low_m.y())};
  const TileKey high{tile_at(high_m.x()), tile_at(high_m.y())};
  const std::span<const TileKey> keys = map.keys();
  auto next = std::ranges::lower_bound(keys, low);
  while (next != keys.end() && next->x <= high.x) {
    if (next->y < low.y || next->y > high.y) {
      const std::int32_t x = next->y < low.y ? next->x : next->x + 1;
      next = std::lower_bound(next, keys.end(), TileKey{x, low.y});
      continue;
    }
    const Eigen::Vector2d corner_m = tile_m * Eigen::Vector2d(next->x, next->y);
    const Eigen::Vector2d nearest_m =
        circle.centre_m.cwiseMax(corner_m).cwiseMin(corner_m + Eigen::Vector2d::Constant(tile_m));
    const bool meets =
        (nearest_m - circle.centre_m).squaredNorm() <= circle.radius_m * circle.radius_m;
    if (meets && !visit(static_cast<std::size_t>(next - keys.begin()))) return;
    ++next;
  }
}

}  // namespace

double match_reach_m(const WindowOptions& options, double range_m, double cell_m) {
  constexpr double kSpare_m = 1.0;
  const double cells_m =
      3.0 * options.own.coarse_cells * cell_m;  // diagonals of a cell and the next
  return range_m + options.mounting_m + kFarthestFound_m + cells_m + kSpare_m;
}

bool serves(const MapWindow& window, const MapTiles& map, const MapCircle& circle) {
  const double apart_m = (window.circle.centre_m - circle.centre_m).norm();
  if (apart_m + circle.radius_m <= window.circle.radius_m) return true;
  bool has_all = true;
  for_tiles(map, circle, [&](std::size_t tile) {
    has_all = std::ranges::binary_search(window.tiles, tile);
    return has_all;
  });
  return has_all;
}

WindowBuilder::WindowBuilder(const MapTiles& map, const MapCircle& circle,
                             const WindowOptions& options)
    : map_(&map),
      options_(options.own),
      ndt_(map.head().ndt),
      window_(std::make_shared<MapWindow>()) {
  window_->circle = circle;
  for_tiles(map, circle, [&](std::size_t tile) {
    window_->tiles.push_back(tile);
    return true;
  });
}

WindowBuilder::WindowBuilder(NdtMap whole, const WindowOptions& options)
    : options_(options.own), ndt_(std::move(whole)), window_(std::make_shared<MapWindow>()) {
  window_->circle.radius_m = std::numeric_limits<double>::infinity();
}

void WindowBuilder::read_tile() {
  const std::size_t tile = window_->tiles[read_count_++];
  const Result<std::vector<Nd>> nds = map_->nds(tile);
  if (nds) {
    ndt_.nds.insert(ndt_.nds.end(), nds->begin(), nds->end());
  } else {
    faults_.push_back({tile, nds.error()});
  }
}

bool WindowBuilder::step() {
  if (read_count_ < window_->tiles.size()) {
    read_tile();
    return false;
  }
  if (!own_) own_.emplace(ndt_, options_);
  if (window_->own.levels.empty()) {
    if (own_->step()) window_->own = own_->take();
    return false;
  }
  // An annealed localizer shares its grids with that for samples.
  if (!options_.is_annealed && !samples_) {
    samples_.emplace(ndt_, options_for_samples(options_.coarse_cells));
  }
  if (window_->samples.levels.empty()) {
    if (!samples_) {
      window_->samples = localizer_for_samples(window_->own, ndt_, options_.coarse_cells);
    } else if (samples_->step()) {
      window_->samples = samples_->take();
    }
    return false;
  }
  window_->structures = StructureMap(ndt_, window_->own.levels.back().grid);
  return true;
}

}  // namespace sightline
