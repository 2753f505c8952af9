#include "formats/reader/reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>

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

bool is_finite(const std::array<double, 3>& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]);
}

}  // namespace

// The nearest site so far, and where it is stored.
struct MapReader::Nearest {
  double distance2_m2 = 0.0;  // at first the square of the reach
  std::uint32_t site = kNoSite;
  std::uint64_t row = 0;
  std::uint64_t row_count = 0;
  const std::byte* layer = nullptr;
};

MapReader::MapReader(MappedFile file, const MapContainer& container)
    : file_(std::move(file)), container_(container) {
  const schema::Manifest& manifest = *container.manifest;
  ranges_m_.assign(manifest.ranges_m()->begin(), manifest.ranges_m()->end());
  for (const schema::Promise* promise : *manifest.promises()) {
    limits_m_.push_back(promise->limit_m());
  }
  const schema::Vector3& origin_m = *manifest.origin_world_m();
  info_.map_id = manifest.map_id()->string_view();
  info_.version = manifest.version()->string_view();
  info_.release = manifest.release();
  info_.origin_world_m = {origin_m.x(), origin_m.y(), origin_m.z()};
  info_.tile_m = manifest.tile_m();
  info_.reach_m = manifest.reach_m();
  info_.site_count = manifest.site_count();
  info_.tile_count = container.directory->tiles()->size();
  info_.ranges_m = ranges_m_;
  info_.limits_m = limits_m_;
  tile_states_ = std::make_unique<std::atomic<std::uint8_t>[]>(info_.tile_count);
}

Result<MapReader> MapReader::open(MappedFile file, std::span<const std::byte> bytes) {
  const Result<MapContainer> container = open_container(bytes);
  if (!container) return container.error();
  return MapReader(std::move(file), *container);
}

Result<MapReader> MapReader::open(std::span<const std::byte> bytes) {
  return open(MappedFile(), bytes);
}

Result<MapReader> MapReader::open(const std::string& path) {
  Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  const std::span<const std::byte> bytes = file->bytes();
  Result<MapReader> reader = open(std::move(*file), bytes);
  if (reader) return reader;
  Error error = reader.error();
  error.file = path;
  return error;
}

Result<const std::byte*> MapReader::checked_tile(std::uint32_t tile,
                                                 const schema::Block& layer) const {
  const std::byte* data = located_bytes(container_, layer).data();
  if (tile_states_[tile].load(std::memory_order_acquire) == kGood) return data;
  const Result<std::span<const std::byte>> bytes = stored_bytes(container_, layer);
  if (!bytes) return bytes.error();
  tile_states_[tile].store(kGood, std::memory_order_release);
  return data;
}

Result<void> MapReader::search(std::int32_t x, std::int32_t y, const std::array<double, 3>& p_m,
                               Nearest& nearest) const {
  const double gap_x_m = gap_m(p_m[0], x, info_.tile_m);
  const double gap_y_m = gap_m(p_m[1], y, info_.tile_m);
  if (gap_x_m * gap_x_m + gap_y_m * gap_y_m > nearest.distance2_m2) return {};
  const std::optional<std::uint32_t> tile = find_tile(container_, x, y);
  if (!tile) return {};
  const schema::Block* layer = find_layer(container_, *tile, kRangeLayer);
  if (layer == nullptr) return {};
  const Result<const std::byte*> data = checked_tile(*tile, *layer);
  if (!data) return data.error();
  const RangeLayout layout(layer->row_count(), ranges_m_.size(), limits_m_.size());
  for (std::uint64_t row = 0; row < layer->row_count(); ++row) {
    const double dx_m = load<double>(*data + layout.p_x, row) - p_m[0];
    const double dy_m = load<double>(*data + layout.p_y, row) - p_m[1];
    const double dz_m = load<double>(*data + layout.p_z, row) - p_m[2];
    const double distance2_m2 = dx_m * dx_m + dy_m * dy_m + dz_m * dz_m;
    if (!(distance2_m2 <= nearest.distance2_m2)) continue;
    const auto site = load<std::uint32_t>(*data + layout.site, row);
    if (distance2_m2 == nearest.distance2_m2 && site >= nearest.site) continue;
    nearest = {distance2_m2, site, row, layer->row_count(), *data};
  }
  return {};
}

Result<RangeAnswer> MapReader::answer(const Nearest& nearest, double limit_m) const {
  RangeAnswer answer;
  answer.range_m = ranges_m_.back();
  answer.mean_error_m = std::numeric_limits<double>::infinity();
  const auto above = std::upper_bound(limits_m_.begin(), limits_m_.end(), limit_m);
  if (above == limits_m_.begin()) answer.flags |= kAnswerTighterLimit;
  if (nearest.layer == nullptr) {
    answer.flags |= kAnswerFar;
    return answer;
  }
  answer.site = nearest.site;
  answer.distance_m = std::sqrt(nearest.distance2_m2);
  const std::size_t ranges = ranges_m_.size();
  const std::size_t limits = limits_m_.size();
  const RangeLayout layout(nearest.row_count, ranges, limits);
  std::size_t range = ranges - 1;
  if (above != limits_m_.begin()) {
    const auto limit = static_cast<std::size_t>(above - limits_m_.begin()) - 1;
    const std::uint64_t choice = nearest.row * limits + limit;
    range = load<std::uint8_t>(nearest.layer + layout.range_index, choice);
    if (range >= ranges) {
      return Error{ErrorCode::kBadLayer, "a site takes a range that the map does not have", "",
                   "site " + std::to_string(nearest.site)};
    }
    answer.flags |= load<std::uint8_t>(nearest.layer + layout.range_flags, choice);
    answer.probability = load<double>(nearest.layer + layout.probability,
                                      (nearest.row * ranges + range) * limits + limit);
  }
  answer.range_m = ranges_m_[range];
  answer.mean_error_m =
      load<double>(nearest.layer + layout.mean_error, nearest.row * ranges + range);
  return answer;
}

Result<RangeAnswer> MapReader::observation_range(const std::array<double, 3>& position_world_m,
                                                 double limit_m) const {
  if (!is_finite(position_world_m) || !std::isfinite(limit_m) || limit_m <= 0.0) {
    return Error{ErrorCode::kBadArgument,
                 "a position must be finite, and a limit finite and above 0", "", ""};
  }
  std::array<double, 3> p_m{};
  for (std::size_t i = 0; i < 3; ++i) p_m[i] = position_world_m[i] - info_.origin_world_m[i];
  Nearest nearest;
  nearest.distance2_m2 = info_.reach_m * info_.reach_m;
  const double tile_x = std::floor(p_m[0] / info_.tile_m);
  const double tile_y = std::floor(p_m[1] / info_.tile_m);
  // Beyond this no tile can be: keys are 32 bits wide.
  constexpr double kFarthestTile = 0x1.0p30;
  if (std::max(std::abs(tile_x), std::abs(tile_y)) > kFarthestTile) return answer(nearest, limit_m);
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
  return answer(nearest, limit_m);
}

}  // namespace sightline
