#include "formats/reader/tile_search.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "map_generated.h"

namespace sightline {
namespace {

constexpr std::uint8_t kGood = 1;  // a tile that was checked

// Element i of a column, as it lies in the file.
template <class T>
T load(const std::byte* column, std::uint64_t i) {
  T value;
  std::memcpy(&value, column + i * sizeof(T), sizeof value);
  return value;
}

// Distance from a coordinate to the interval of one tile along an axis.
double gap_m(double value_m, std::int32_t tile, double tile_m) {
  const double low_m = tile * tile_m;
  return std::max({0.0, low_m - value_m, value_m - (low_m + tile_m)});
}

}  // namespace

TileSearch::TileSearch(const MapContainer& container)
    : container_(container),
      tile_m_(container.manifest->tile_m()),
      reach_m_(container.manifest->reach_m()),
      range_count_(container.manifest->ranges_m()->size()),
      limit_count_(container.manifest->promises()->size()),
      tile_states_(
          std::make_unique<std::atomic<std::uint8_t>[]>(container.directory->tiles()->size())) {}

Result<const std::byte*> TileSearch::checked_tile(std::uint32_t tile,
                                                 const schema::Block& layer) const {
  const std::byte* data = located_bytes(container_, layer).data();
  if (tile_states_[tile].load(std::memory_order_acquire) == kGood) return data;
  const Result<std::span<const std::byte>> bytes = stored_bytes(container_, layer);
  if (!bytes) return bytes.error();
  tile_states_[tile].store(kGood, std::memory_order_release);
  return data;
}

Result<void> TileSearch::search(std::int32_t x, std::int32_t y, const std::array<double, 3>& p_m,
                               StoredSite& nearest) const {
  const double gap_x_m = gap_m(p_m[0], x, tile_m_);
  const double gap_y_m = gap_m(p_m[1], y, tile_m_);
  if (gap_x_m * gap_x_m + gap_y_m * gap_y_m > nearest.distance2_m2) return {};
  const std::optional<std::uint32_t> tile = find_tile(container_, x, y);
  if (!tile) return {};
  const schema::Block* layer = find_layer(container_, *tile, kRangeLayer);
  if (layer == nullptr) return {};
  const Result<const std::byte*> data = checked_tile(*tile, *layer);
  if (!data) return data.error();
  const RangeLayout layout(layer->row_count(), range_count_, limit_count_);
  for (std::uint64_t row = 0; row < layer->row_count(); ++row) {
    const double dx_m = load<double>(*data + layout.p_x, row) - p_m[0];
    const double dy_m = load<double>(*data + layout.p_y, row) - p_m[1];
    const double dz_m = load<double>(*data + layout.p_z, row) - p_m[2];
    const double distance2_m2 = dx_m * dx_m + dy_m * dy_m + dz_m * dz_m;
    if (!(distance2_m2 <= nearest.distance2_m2)) continue;
    const auto site = load<std::uint32_t>(*data + layout.site, row);
    if (distance2_m2 == nearest.distance2_m2 && nearest.layer != nullptr && site >= nearest.site) {
      continue;
    }
    nearest = {distance2_m2, site, row, layer->row_count(), *data};
  }
  return {};
}

Result<StoredSite> TileSearch::nearest(const std::array<double, 3>& p_m) const {
  StoredSite nearest;
  nearest.distance2_m2 = reach_m_ * reach_m_;
  const double tile_x = std::floor(p_m[0] / tile_m_);
  const double tile_y = std::floor(p_m[1] / tile_m_);
  // Beyond this no tile can be: keys are 32 bits wide.
  constexpr double kFarthestTile = 0x1.0p30;
  if (std::max(std::abs(tile_x), std::abs(tile_y)) > kFarthestTile) return nearest;
  const auto x = static_cast<std::int32_t>(tile_x);
  const auto y = static_cast<std::int32_t>(tile_y);
  // The reach is at most a tile, so one ring of neighbours is enough; the own tile comes first
  // because what it finds spares most of them.
  const Result<void> own = search(x, y, p_m, nearest);
  if (!own) return own.error();
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      if (dx == 0 && dy == 0) continue;
      const Result<void> neighbour = search(x + dx, y + dy, p_m, nearest);
      if (!neighbour) return neighbour.error();
    }
  }
  return nearest;
}

}  // namespace sightline
