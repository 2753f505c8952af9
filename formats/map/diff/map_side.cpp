#include "formats/map/diff/map_side.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/base/portable_math.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

template <class T>
T load(std::span<const std::byte> bytes, std::uint64_t column, std::uint64_t i) {
  T value;
  std::memcpy(&value, bytes.data() + column + i * sizeof(T), sizeof value);
  return value;
}

Error at_layer(Error error, TileKey key, std::string_view layer) {
  error.place = tile_place(key.x, key.y) + " layer " + std::string(layer) +
                (error.place.empty() ? "" : ", " + error.place);
  return error;
}

Result<SiteRow> load_site(std::span<const std::byte> raw, const RangeLayout& layout,
                          std::uint64_t row, const CompiledMap& card) {
  const std::size_t limits = card.ranges.promises.size();
  const std::size_t ranges = card.ranges.looks.size();
  const SiteShape choices = card.ranges.shape();
  const SiteShape probabilities{ranges, limits};
  SiteRow site;
  site.site = load<std::uint32_t>(raw, layout.site, row);
  site.run = load<std::uint32_t>(raw, layout.run, row);
  site.s_m = load<double>(raw, layout.s, row);
  site.p_m = {load<double>(raw, layout.p_x, row), load<double>(raw, layout.p_y, row),
              load<double>(raw, layout.p_z, row)};
  for (std::size_t limit = 0; limit < limits; ++limit) {
    const std::size_t range =
        load<std::uint8_t>(raw, layout.range_index, choices.index(row, limit));
    if (range >= ranges || !site.p_m.allFinite() || !std::isfinite(site.s_m)) {
      return Error{ErrorCode::kBadLayer,
                   "a site has no position or a range that the map does not have", "",
                   concat("row ", row)};
    }
    site.answers.push_back(
        {card.ranges.looks[range].range_m,
         load<double>(raw, layout.probability, probabilities.index(row, range, limit)),
         load<std::uint8_t>(raw, layout.range_flags, choices.index(row, limit)),
         load<Reason>(raw, layout.range_reason, choices.index(row, limit)), 0.0});
  }
  return site;
}

// How far a coordinate is from a tile along one axis.
double gap_m(double p_m, std::int32_t key, double tile_m) {
  const double begin_m = key * tile_m;
  return std::max({0.0, begin_m - p_m, p_m - (begin_m + tile_m)});
}

}  // namespace

MapSide::MapSide(const MapContainer& container)
    : container_(container),
      bytes_read_(kHeaderSize + kTrailerSize + container.header.manifest_size +
                  container.header.directory_size) {}

Result<MapSide> MapSide::open(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const MapContainer container, open_container(file));
  MapSide side(container);
  SIGHTLINE_TRY(decode_manifest(*container.manifest, side.card_));
  SIGHTLINE_TRY(side.find_virtual_points());
  return side;
}

// A map that was stripped has no factors: then nothing is known of the work at a site.
Result<void> MapSide::find_virtual_points() {
  const schema::Block* names = find_section(container_, kFactorNames);
  if (names == nullptr || names->version() != kFactorNamesVersion || names->row_count() == 0 ||
      names->row_count() > kMostFactors) {
    return {};
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> raw, raw_bytes(*names));
  FactorTable factors;
  factors.factors.resize(names->row_count());
  SIGHTLINE_TRY(decode_factor_names(raw, factors));
  factor_count_ = factors.factors.size();
  const auto found = std::ranges::find(factors.factors, "virtual_points");
  if (found == factors.factors.end()) return {};
  virtual_points_ = static_cast<std::uint64_t>(found - factors.factors.begin());
  return {};
}

// `range_index` is of the range layer: [row][limit].
Result<void> MapSide::add_virtual_points(std::uint32_t tile,
                                         std::span<const std::uint8_t> range_index,
                                         std::vector<SiteRow>& rows) {
  const schema::Block* block =
      virtual_points_ ? find_layer(container_, tile, kFactorLayer) : nullptr;
  if (block == nullptr || block->version() != kFactorLayerVersion) return {};
  SIGHTLINE_ASSIGN(const std::vector<std::byte> raw, raw_bytes(*block));
  const std::uint64_t ranges = card_.ranges.looks.size();
  const SiteShape shape{ranges, factor_count_};
  const std::uint64_t values = aligned(4 * rows.size());
  if (block->row_count() != rows.size() ||
      raw.size() != aligned(values + 8 * shape.size(rows.size()))) {
    return Error{ErrorCode::kBadLayer, "the size of the layer does not match its sites"};
  }
  for (std::uint64_t row = 0; row < rows.size(); ++row) {
    const auto points_at = [&](std::uint64_t range) {
      return load<double>(raw, values, shape.index(row, range, *virtual_points_));
    };
    rows[row].longest_virtual_points = points_at(ranges - 1);
    const std::size_t limits = rows[row].answers.size();
    for (std::size_t limit = 0; limit < limits; ++limit) {
      rows[row].answers[limit].virtual_points =
          points_at(range_index[card_.ranges.shape().index(row, limit)]);
    }
  }
  return {};
}

std::uint64_t MapSide::nd_count() const { return container_.manifest->nd_count(); }
std::uint32_t MapSide::site_count() const { return container_.manifest->site_count(); }
std::uint32_t MapSide::tile_count() const { return container_.directory->tiles()->size(); }

TileKey MapSide::tile_key(std::uint32_t tile) const {
  const schema::Tile* entry = container_.directory->tiles()->Get(tile);
  return {entry->x(), entry->y()};
}

Result<std::vector<std::byte>> MapSide::raw_bytes(const schema::Block& block) {
  bytes_read_ += block.stored_size();
  SIGHTLINE_ASSIGN(const std::span<const std::byte> stored, stored_bytes(container_, block));
  if (block.codec() != schema::Codec::None) {
    return unpack(static_cast<BlockCodec>(block.codec()), stored, block.row_count(),
                  block.raw_size());
  }
  return std::vector<std::byte>(stored.begin(), stored.end());
}

Result<std::vector<Nd>> MapSide::nds(std::uint32_t tile) {
  const TileKey key = tile_key(tile);
  const schema::Block* block = find_layer(container_, tile, kNdtLayer);
  if (block == nullptr) return std::vector<Nd>();
  const Result<std::vector<std::byte>> raw = raw_bytes(*block);
  if (!raw) return at_layer(raw.error(), key, kNdtLayer);
  NdtMap ndt;
  ndt.cell_m = card_.ndt.cell_m;
  ndt.tile_m = card_.ndt.tile_m;
  const Result<void> decoded = decode_ndt_layer(*raw, block->row_count(), key, ndt);
  if (!decoded) return at_layer(decoded.error(), key, kNdtLayer);
  for (std::size_t i = 1; i < ndt.nds.size(); ++i) {
    if (ndt.nds[i - 1].key < ndt.nds[i].key) continue;
    return at_layer({ErrorCode::kBadOrder, "cells must ascend", "", "row " + std::to_string(i)},
                    key, kNdtLayer);
  }
  return std::move(ndt.nds);
}

Result<const TileSites*> MapSide::sites(std::uint32_t tile) {
  const auto known = sites_.find(tile);
  if (known != sites_.end()) return &known->second;
  std::vector<SiteRow> rows;
  const schema::Block* block = find_layer(container_, tile, kRangeLayer);
  if (block != nullptr) {
    const Result<std::vector<std::byte>> raw = raw_bytes(*block);
    if (!raw) return at_layer(raw.error(), tile_key(tile), kRangeLayer);
    const RangeLayout layout(block->row_count(), answer_shape(card_));
    for (std::uint64_t row = 0; row < block->row_count(); ++row) {
      const Result<SiteRow> site = load_site(*raw, layout, row, card_);
      if (!site) return at_layer(site.error(), tile_key(tile), kRangeLayer);
      rows.push_back(*site);
    }
    const std::span indices(reinterpret_cast<const std::uint8_t*>(raw->data()) + layout.range_index,
                            rows.size() * card_.ranges.promises.size());
    const Result<void> added = add_virtual_points(tile, indices, rows);
    if (!added) return at_layer(added.error(), tile_key(tile), kFactorLayer);
  }
  std::vector<Eigen::Vector3d> places_m;
  for (const SiteRow& row : rows) places_m.push_back(row.p_m);
  return &sites_.emplace(tile, TileSites{std::move(rows), PointGrid(places_m)}).first->second;
}

Result<SiteColumn> MapSide::column(const SiteColumn& card) {
  const std::string name = column_section(card.name);
  const schema::Block* block = find_section(container_, name);
  if (block == nullptr || block->version() != column_version(!card.steps.empty())) {
    return Error{ErrorCode::kBadLayer, "the map lists a column that it does not contain", "",
                 "section " + name};
  }
  SIGHTLINE_ASSIGN(const std::vector<std::byte> raw, raw_bytes(*block));
  SiteColumn column = card;
  SIGHTLINE_TRY(decode_column(raw, site_count(), column));
  return column;
}

Digest MapSide::column_digest(const std::string& name) const {
  Digest digest{};
  for (const schema::SiteColumn* column : *container_.manifest->columns()) {
    if (column->name()->string_view() != name) continue;
    std::copy(column->digest()->bytes()->begin(), column->digest()->bytes()->end(), digest.begin());
  }
  return digest;
}

Result<void> MapSide::search(TileKey key, const Sought& sought, NearestSite& nearest) {
  const auto& [p_m, most_m, level] = sought;
  const double tile_m = card_.ndt.tile_m;
  const double gap = portable_hypot(gap_m(p_m.x(), key.x, tile_m), gap_m(p_m.y(), key.y, tile_m));
  if (gap > (nearest.row == nullptr ? most_m : nearest.distance_m)) return {};
  const std::optional<std::uint32_t> tile = find_tile(container_, key.x, key.y);
  if (!tile) return {};
  SIGHTLINE_ASSIGN(const TileSites* of_tile, sites(*tile));
  const std::optional<NearPoint> found = level == Level::kSame
                                             ? of_tile->grid.nearest_on_level(p_m, most_m)
                                             : of_tile->grid.nearest(p_m, most_m);
  if (!found) return {};
  const SiteRow& row = of_tile->rows[found->index];
  const bool is_nearer = nearest.row == nullptr || found->distance_m < nearest.distance_m ||
                         (found->distance_m == nearest.distance_m && row.site < nearest.row->site);
  if (is_nearer) nearest = {&row, found->distance_m};
  return {};
}

Result<NearestSite> MapSide::nearest(const Eigen::Vector3d& p_m, double most_m, Level level) {
  const double tile_m = card_.ndt.tile_m;
  NearestSite nearest;
  // Beyond this no tile can be: keys are 32 bits wide.
  constexpr double kFarthestTile = 0x1.0p30;
  if (p_m.head<2>().cwiseAbs().maxCoeff() > kFarthestTile * tile_m) return nearest;
  const TileKey own = sightline::tile_key(p_m, tile_m);  // not that of a tile by its number
  // The own tile first: what it finds spares most of its neighbours.
  const Sought sought{p_m, most_m, level};
  SIGHTLINE_TRY(search(own, sought, nearest));
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      if (dx == 0 && dy == 0) continue;
      SIGHTLINE_TRY(search({own.x + dx, own.y + dy}, sought, nearest));
    }
  }
  return nearest;
}

}  // namespace sightline
