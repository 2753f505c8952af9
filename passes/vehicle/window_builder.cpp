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

// The numbers of the tiles that meet a circle, ascending.
std::vector<std::size_t> tiles_in(const MapTiles& map, const MapCircle& circle) {
  const double tile_m = map.head().ndt.tile_m;
  const auto tile_at = [&](double along_m) { return floor_to_int(along_m / tile_m); };
  const Eigen::Vector2d low_m = circle.centre_m - Eigen::Vector2d::Constant(circle.radius_m);
  const Eigen::Vector2d high_m = circle.centre_m + Eigen::Vector2d::Constant(circle.radius_m);
  const TileKey low{tile_at(low_m.x()), tile_at(low_m.y())};
  const TileKey high{tile_at(high_m.x()), tile_at(high_m.y())};
  std::vector<std::size_t> tiles;
  const std::span<const TileKey> keys = map.keys();
  auto next = std::ranges::lower_bound(keys, low);
  while (next != keys.end() && next->x <= high.x) {
    if (next->y >= low.y && next->y <= high.y) {
      tiles.push_back(static_cast<std::size_t>(next - keys.begin()));
      ++next;
    } else {
      const std::int32_t x = next->y < low.y ? next->x : next->x + 1;
      next = std::lower_bound(next, keys.end(), TileKey{x, low.y});
    }
  }
  return tiles;
}

}  // namespace

double match_reach_m(const WindowOptions& options, double range_m, double cell_m) {
  constexpr double kSpare_m = 1.0;
  const double cells_m =
      3.0 * options.own.coarse_cells * cell_m;  // diagonals of a cell and the next
  return range_m + options.mounting_m + kFarthestFound_m + cells_m + kSpare_m;
}

bool serves(const MapWindow& window, const MapCircle& circle) {
  const double apart_m = (window.circle.centre_m - circle.centre_m).norm();
  return apart_m + circle.radius_m <= window.circle.radius_m;
}

WindowBuilder::WindowBuilder(const MapTiles& map, const MapCircle& circle,
                             const WindowOptions& options)
    : map_(&map),
      options_(options.own),
      ndt_(map.head().ndt),
      window_(std::make_shared<MapWindow>()) {
  window_->circle = circle;
  tiles_ = tiles_in(map, circle);
}

WindowBuilder::WindowBuilder(NdtMap whole, const WindowOptions& options)
    : options_(options.own), ndt_(std::move(whole)), window_(std::make_shared<MapWindow>()) {
  window_->circle.radius_m = std::numeric_limits<double>::infinity();
}

void WindowBuilder::read_tile() {
  const std::size_t tile = tiles_[read_count_++];
  const Result<std::vector<Nd>> nds = map_->nds(tile);
  if (!nds) {
    faults_.push_back({tile, nds.error()});
    return;
  }
  const auto& [centre_m, radius_m] = window_->circle;
  for (const Nd& nd : *nds) {
    const Eigen::Vector2d cell_m = cell_centre_m(nd.key, ndt_.cell_m).head<2>();
    if ((cell_m - centre_m).squaredNorm() <= radius_m * radius_m) ndt_.nds.push_back(nd);
  }
}

bool WindowBuilder::step() {
  if (read_count_ < tiles_.size()) {
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
