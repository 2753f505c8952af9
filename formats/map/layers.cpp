#include "formats/map/layers.h"

#include <cmath>
#include <cstring>
#include <map>

#include "formats/map/container/packed_columns.h"
#include "formats/map/container/small_nds.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

template <class T>
void store(std::vector<std::byte>& bytes, std::uint64_t column, std::uint64_t i, T value) {
  std::memcpy(bytes.data() + column + i * sizeof(T), &value, sizeof value);
}

template <class T>
T load(std::span<const std::byte> bytes, std::uint64_t column, std::uint64_t i) {
  T value;
  std::memcpy(&value, bytes.data() + column + i * sizeof(T), sizeof value);
  return value;
}

Error bad(ErrorCode code, const char* message, std::uint64_t row) {
  return {code, message, "", concat("row ", row)};
}

Error bad_site(ErrorCode code, const char* message, std::uint64_t row, std::uint32_t id) {
  return {code, message, "", concat("row ", row, ", site ", id)};
}

Nd load_nd(std::span<const std::byte> raw, const NdtLayout& layout, std::uint64_t row,
           double cell_m) {
  const CellKey key = {load<std::int32_t>(raw, layout.column[0], row),
                       load<std::int32_t>(raw, layout.column[1], row),
                       load<std::int32_t>(raw, layout.column[2], row)};
  return nd_of(load_nd_row(raw, layout, row), key, cell_m);
}

Site load_site(std::span<const std::byte> raw, const RangeLayout& layout, std::uint64_t row) {
  Site site;
  site.run = load<std::uint32_t>(raw, layout.run, row);
  site.s_m = load<double>(raw, layout.s, row);
  site.p_map_m = {load<double>(raw, layout.p_x, row), load<double>(raw, layout.p_y, row),
                  load<double>(raw, layout.p_z, row)};
  for (int i = 0; i < 12; ++i) {
    site.T_map_vehicle(i / 4, i % 4) =
        load<double>(raw, layout.pose, row * 12 + static_cast<std::uint64_t>(i));
  }
  return site;
}

void store_site(const CompiledMap& map, std::uint32_t id, std::uint64_t row,
                const RangeLayout& layout, std::vector<std::byte>& raw) {
  const Site& site = map.sites.sites[id];
  store(raw, layout.site, row, id);
  store(raw, layout.run, row, site.run);
  store(raw, layout.s, row, site.s_m);
  store(raw, layout.p_x, row, site.p_map_m.x());
  store(raw, layout.p_y, row, site.p_map_m.y());
  store(raw, layout.p_z, row, site.p_map_m.z());
  for (int i = 0; i < 12; ++i) {
    store(raw, layout.pose, row * 12 + static_cast<std::uint64_t>(i),
          site.T_map_vehicle(i / 4, i % 4));
  }
  const int flags = (map.predicted.out_of_fold[id] != 0 ? kSiteOutOfFold : 0) |
                    (map.predicted.has_history[id] != 0 ? kSiteHasHistory : 0);
  store(raw, layout.site_flags, row, static_cast<std::uint8_t>(flags));
}

// The rows of per-site columns of `per_site` elements each, between a vector of all sites and a
// layer.
template <class T>
void store_columns(const std::vector<T>& values, std::size_t per_site, std::uint32_t id,
                   std::uint64_t row, std::uint64_t column, std::vector<std::byte>& raw) {
  for (std::size_t i = 0; i < per_site; ++i) {
    store(raw, column, row * per_site + i, values[id * per_site + i]);
  }
}

template <class T>
void load_columns(std::span<const std::byte> raw, std::uint64_t column, std::uint64_t row,
                  std::size_t per_site, std::uint32_t id, std::vector<T>& values) {
  for (std::size_t i = 0; i < per_site; ++i) {
    values[id * per_site + i] = load<T>(raw, column, row * per_site + i);
  }
}

// Calls visit(values of all sites, how many are of one, where they begin in the layer) for what the
// map answers: of the ranges, then of the looks that take a sample.
template <class Map, class Visit>
void for_answers(Map& map, const AnswerShape& shape, const RangeLayout& layout,
                 const Visit& visit) {
  visit(map.ranges.range_index, shape.limits, layout.range_index);
  visit(map.ranges.flags, shape.limits, layout.range_flags);
  visit(map.ranges.reasons, shape.limits, layout.range_reason);
  visit(map.predicted.mean_m, shape.ranges, layout.mean_error);
  visit(map.predicted.within_probability, shape.ranges * shape.limits, layout.probability);
  visit(map.predicted.extrapolated, shape.ranges, layout.extrapolated);
  if (!map.looks) return;
  auto& [predicted, ranges, quality, factors] = *map.looks;
  visit(ranges.range_index, shape.limits, layout.look_index);
  visit(ranges.flags, shape.limits, layout.look_flags);
  visit(ranges.reasons, shape.limits, layout.look_reason);
  visit(predicted.mean_m, shape.looks, layout.look_mean_error);
  visit(predicted.within_probability, shape.looks * shape.limits, layout.look_probability);
  visit(predicted.extrapolated, shape.looks, layout.look_extrapolated);
}

// As RangeLayout has them.
std::vector<ArrayShape> columns_of(std::uint64_t rows, const AnswerShape& shape) {
  const auto ranges = static_cast<std::uint32_t>(shape.ranges);
  const auto limits = static_cast<std::uint32_t>(shape.limits);
  const auto looks = static_cast<std::uint32_t>(shape.looks);
  const std::uint32_t look_limits = looks > 0 ? limits : 0;
  return {{rows, 1, 4},
          {rows, 1, 4},
          {rows, 1, 8},
          {rows, 1, 8},
          {rows, 1, 8},
          {rows, 1, 8},
          {rows, limits, 1},
          {rows, limits, 1},
          {rows, ranges, 8},
          {rows, ranges * limits, 8},
          {rows, 1, 1},
          {rows, ranges, 1},
          {rows, 12, 8},
          {rows, look_limits, 1},
          {rows, look_limits, 1},
          {rows, looks, 8},
          {rows, looks * limits, 8},
          {rows, looks, 1},
          {rows, limits, 1},
          {rows, look_limits, 1}};
}

void set_site_flags(std::uint8_t flags, std::uint32_t id, PredictedError& predicted) {
  predicted.out_of_fold[id] = (flags & kSiteOutOfFold) != 0 ? 1 : 0;
  predicted.has_history[id] = (flags & kSiteHasHistory) != 0 ? 1 : 0;
}

void make_room_for(std::size_t sites, RangeTable& ranges) {
  ranges.site_count = static_cast<std::uint32_t>(sites);
  ranges.range_index.resize(ranges.shape().size(sites));
  ranges.flags.resize(ranges.shape().size(sites));
  ranges.reasons.resize(ranges.shape().size(sites));
}

void make_room_for(std::size_t sites, PredictedError& predicted) {
  predicted.site_count = static_cast<std::uint32_t>(sites);
  predicted.mean_m.resize(predicted.mean_shape().size(sites));
  predicted.within_probability.resize(predicted.probability_shape().size(sites));
  predicted.extrapolated.resize(predicted.mean_m.size());
  predicted.out_of_fold.resize(sites);
  predicted.has_history.resize(sites);
}

}  // namespace

AnswerShape answer_shape(const CompiledMap& map) {
  return {map.ranges.looks.size(), map.ranges.promises.size(),
          map.looks ? map.looks->ranges.looks.size() : 0, map.size == MapSize::kPromise};
}

std::vector<TileRows> tiles_of(const CompiledMap& map) {
  std::map<TileKey, TileRows> tiles;
  for (std::size_t i = 0; i < map.ndt.nds.size(); ++i) {
    tiles[tile_of(map.ndt.nds[i].key, map.ndt.cell_m, map.ndt.tile_m)].nds.push_back(
        static_cast<std::uint32_t>(i));
  }
  for (std::size_t i = 0; i < map.sites.sites.size(); ++i) {
    tiles[tile_key(map.sites.sites[i].p_map_m, map.ndt.tile_m)].sites.push_back(
        static_cast<std::uint32_t>(i));
  }
  std::vector<TileRows> sorted;
  for (auto& [key, rows] : tiles) {
    rows.key = key;
    sorted.push_back(std::move(rows));
  }
  return sorted;
}

std::vector<std::byte> encode_ndt_layer(const NdtMap& ndt, std::span<const std::uint32_t> rows) {
  const NdtLayout layout(rows.size());
  std::vector<std::byte> raw(layout.size);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Nd& nd = ndt.nds[rows[row]];
    store(raw, layout.column[0], row, nd.key.x);
    store(raw, layout.column[1], row, nd.key.y);
    store(raw, layout.column[2], row, nd.key.z);
    store_nd_row(row_of(nd, ndt.cell_m), layout, row, raw);
  }
  return raw;
}

Result<void> decode_ndt_layer(std::span<const std::byte> raw, std::uint64_t row_count, TileKey key,
                              NdtMap& ndt) {
  const NdtLayout layout(row_count);
  SIGHTLINE_CHECK(raw.size() == layout.size);
  for (std::uint64_t row = 0; row < row_count; ++row) {
    Nd nd = load_nd(raw, layout, row, ndt.cell_m);
    if (tile_of(nd.key, ndt.cell_m, ndt.tile_m) != key) {
      return bad(ErrorCode::kBadOrder, "a cell is in another tile", row);
    }
    if (!nd.covariance_m2.allFinite()) {
      return bad(ErrorCode::kBadLayer, "a covariance is not finite", row);
    }
    ndt.nds.push_back(nd);
  }
  decompose(std::span(ndt.nds).subspan(ndt.nds.size() - row_count));
  return {};
}

void make_room_for_sites(std::size_t sites, CompiledMap& map) {
  map.sites.sites.resize(sites);
  make_room_for(sites, map.ranges);
  make_room_for(sites, map.predicted);
  if (!map.looks) return;
  make_room_for(sites, map.looks->ranges);
  make_room_for(sites, map.looks->predicted);
}

std::vector<std::byte> encode_range_layer(const CompiledMap& map,
                                          std::span<const std::uint32_t> rows) {
  const AnswerShape shape = answer_shape(map);
  const RangeLayout layout(rows.size(), shape);
  std::vector<std::byte> raw(layout.size);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const std::uint32_t id = rows[row];
    store_site(map, id, row, layout, raw);
    for_answers(map, shape, layout,
                [&](const auto& values, std::size_t per_site, std::uint64_t at) {
                  store_columns(values, per_site, id, row, at, raw);
                });
  }
  return raw;
}

Result<void> decode_range_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                                TileKey key, CompiledMap& map, std::vector<bool>& is_filled) {
  const AnswerShape shape = answer_shape(map);
  const RangeLayout layout(row_count, shape);
  SIGHTLINE_CHECK(raw.size() == layout.size);
  std::int64_t previous = -1;
  for (std::uint64_t row = 0; row < row_count; ++row) {
    const auto id = load<std::uint32_t>(raw, layout.site, row);
    if (id >= is_filled.size() || is_filled[id] || std::int64_t{id} <= previous) {
      return bad_site(ErrorCode::kBadOrder, "a site is unknown, listed twice or out of order", row,
                      id);
    }
    previous = id;
    is_filled[id] = true;
    map.sites.sites[id] = load_site(raw, layout, row);
    const Eigen::Vector3d& p_m = map.sites.sites[id].p_map_m;
    constexpr double kGridReach = 0x1.0p30;
    if (!p_m.allFinite() || p_m.cwiseAbs().maxCoeff() >= kGridReach * map.ndt.tile_m ||
        tile_key(p_m, map.ndt.tile_m) != key) {
      return bad_site(ErrorCode::kBadOrder, "a site is in another tile", row, id);
    }
    for_answers(map, shape, layout, [&](auto& values, std::size_t per_site, std::uint64_t at) {
      load_columns(raw, at, row, per_site, id, values);
    });
    const auto flags = load<std::uint8_t>(raw, layout.site_flags, row);
    if ((flags & ~(kSiteOutOfFold | kSiteHasHistory)) != 0) {
      return bad_site(ErrorCode::kBadLayer, "a site has an unknown flag", row, id);
    }
    set_site_flags(flags, id, map.predicted);
    if (map.looks) set_site_flags(flags, id, map.looks->predicted);
  }
  return {};
}

StoredBlock store_ndt_layer(std::span<const std::byte> raw, std::uint64_t row_count, double cell_m,
                            MapSize size) {
  if (size == MapSize::kFull) return pack(raw);
  std::optional<std::vector<std::byte>> small = pack_small_nds(raw, row_count, cell_m);
  return small ? StoredBlock{BlockCodec::kNds, std::move(*small)} : pack(raw);
}

// Plain, so that a vehicle needs no decompressor; of a small map it reads the section look-up
// alone.
StoredBlock store_range_layer(std::span<const std::byte> raw, std::uint64_t row_count,
                              const AnswerShape& shape) {
  if (!shape.is_small) return {BlockCodec::kNone, {raw.begin(), raw.end()}};
  return {BlockCodec::kColumns, pack_columns(raw, columns_of(row_count, shape))};
}

}  // namespace sightline
