#include "formats/map/repair/recover.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "formats/map/container/contents_layer.h"
#include "formats/map/container/map_digests.h"
#include "formats/map/drives_section.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/reader/map_checks.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

// A tile as the file tells of it; whether its bytes are whole is another question.
struct FoundTile {
  TileKey key;
  Digest digest{};
  std::vector<PackedBlock> layers;
};

std::vector<FoundTile> tiles_of_directory(const MapContainer& container) {
  std::vector<FoundTile> tiles;
  for (const schema::Tile* entry : *container.directory->tiles()) {
    FoundTile tile;
    tile.key = {entry->x(), entry->y()};
    std::copy(entry->digest()->bytes()->begin(), entry->digest()->bytes()->end(),
              tile.digest.begin());
    for (const schema::Block* block : *entry->layers()) {
      tile.layers.push_back(packed_block(container, *block));
    }
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

// A layer that leaves the file has no bytes, so that its checksum will not match.
FoundTile tile_behind(const TileContents& contents, std::span<const std::byte> rest) {
  FoundTile tile{contents.key, contents.digest, {}};
  for (const ContentsEntry& entry : contents.layers) {
    const bool is_inside =
        entry.offset <= rest.size() && entry.stored_size <= rest.size() - entry.offset;
    tile.layers.push_back(
        {entry.name, entry.version, entry.is_required, entry.codec, entry.row_count, entry.raw_size,
         entry.stored_checksum, entry.raw_digest,
         is_inside ? rest.subspan(entry.offset, entry.stored_size) : std::span<const std::byte>()});
  }
  return tile;
}

std::vector<FoundTile> tiles_that_tell(const MapFront& front) {
  std::map<TileKey, FoundTile> tiles;
  const std::uint64_t begin = aligned(front.header.manifest_offset + front.header.manifest_size);
  for (std::uint64_t offset = begin; offset < front.file.size(); offset += kAlignment) {
    const std::span<const std::byte> rest = front.file.subspan(offset);
    const std::optional<TileContents> contents = decode_contents(rest);
    if (contents) tiles.emplace(contents->key, tile_behind(*contents, rest));
  }
  std::vector<FoundTile> sorted;
  for (auto& [key, tile] : tiles) sorted.push_back(std::move(tile));
  return sorted;
}

const PackedBlock* find_layer(const FoundTile& tile, std::string_view name) {
  const auto found = std::ranges::find(tile.layers, name, &PackedBlock::name);
  return found == tile.layers.end() ? nullptr : &*found;
}

Result<void> check_rows(const PackedBlock& layer, const schema::Manifest& manifest) {
  const bool is_ndt = layer.name == kNdtLayer && layer.version == kNdtLayerVersion;
  const bool is_range = layer.name == kRangeLayer && layer.version == kRangeLayerVersion &&
                        layer.codec == BlockCodec::kNone;
  if ((!is_ndt && !is_range) || layer.row_count == 0 || layer.row_count > kMostRows) {
    return Error{ErrorCode::kBadLayer, "layer " + layer.name + " is of an unknown kind"};
  }
  const std::uint64_t expected = is_ndt ? NdtLayout(layer.row_count).size
                                        : RangeLayout(layer.row_count, answer_shape(manifest)).size;
  if (layer.raw_size == expected) return {};
  return Error{ErrorCode::kBadLayer, "layer " + layer.name + " has another size than its rows"};
}

// Every required layer is what the tile's digest names.
Result<void> check_tile(const FoundTile& tile, const schema::Manifest& manifest) {
  std::vector<BlockName> required;
  for (const PackedBlock& layer : tile.layers) {
    if (!layer.is_required) continue;
    SIGHTLINE_TRY(check_rows(layer, manifest));
    SIGHTLINE_TRY(checked_bytes(layer));
    required.push_back({layer.name, layer.version, layer.row_count, layer.raw_digest});
  }
  if (tile_digest(tile.key, required) == tile.digest) return {};
  return Error{ErrorCode::kDigestMismatch, "the tile does not match its digest"};
}

// The ids of the sites that are left, ascending: a site's new id is its place among them.
using SiteIds = std::vector<std::uint32_t>;

SiteIds sites_of(const std::vector<FoundTile>& tiles) {
  SiteIds ids;
  for (const FoundTile& tile : tiles) {
    const PackedBlock* layer = find_layer(tile, kRangeLayer);
    if (layer == nullptr) continue;
    const std::size_t before = ids.size();
    ids.resize(before + layer->row_count);
    std::memcpy(ids.data() + before, layer->stored.data(), layer->row_count * sizeof ids[0]);
  }
  std::ranges::sort(ids);
  return ids;
}

// The first column of a layer of sites is their ids.
std::vector<std::byte> renumbered(std::span<const std::byte> raw, std::uint64_t row_count,
                                  const SiteIds& ids) {
  std::vector<std::byte> changed(raw.begin(), raw.end());
  for (std::uint64_t row = 0; row < row_count; ++row) {
    std::uint32_t id = 0;
    std::memcpy(&id, raw.data() + row * sizeof id, sizeof id);
    id = static_cast<std::uint32_t>(std::ranges::lower_bound(ids, id) - ids.begin());
    std::memcpy(changed.data() + row * sizeof id, &id, sizeof id);
  }
  return changed;
}

Result<void> decode_tiles(const std::vector<FoundTile>& tiles, const SiteIds& ids,
                          CompiledMap& map) {
  make_room_for_sites(ids.size(), map);
  std::vector<bool> is_filled(ids.size());
  for (const FoundTile& tile : tiles) {
    if (const PackedBlock* layer = find_layer(tile, kNdtLayer)) {
      SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(*layer));
      SIGHTLINE_TRY(decode_ndt_layer(raw.bytes(), layer->row_count, tile.key, map.ndt));
    }
    if (const PackedBlock* layer = find_layer(tile, kRangeLayer)) {
      SIGHTLINE_TRY(decode_range_layer(renumbered(layer->stored, layer->row_count, ids),
                                       layer->row_count, tile.key, map, is_filled));
    }
  }
  return {};
}

// A run ends where sites are missing, and arc length begins anew.
void cut_runs(const SiteIds& ids, Sites& sites) {
  std::uint32_t run = 0;
  std::uint32_t run_before = 0;
  double start_m = 0.0;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    Site& site = sites.sites[i];
    if (i == 0 || ids[i] != ids[i - 1] + 1 || site.run != run_before) {
      run += i == 0 ? 0 : 1;
      start_m = site.s_m;
    }
    run_before = std::exchange(site.run, run);
    site.s_m -= start_m;
  }
}

// Where factors lie, and what they are told for.
struct FactorPlace {
  std::string_view names;  // of the section
  std::string_view layer;
  const std::vector<Look>& looks;
};

// Without any factor where the map has none.
Result<FactorTable> decode_factors(const MapContainer& container,
                                   const std::vector<FoundTile>& tiles, const SiteIds& ids,
                                   const FactorPlace& place) {
  FactorTable factors;
  const schema::Block* entry = find_section(container, place.names);
  if (entry == nullptr) return factors;
  const PackedBlock names = packed_block(container, *entry);
  SIGHTLINE_ASSIGN(const RawBytes text, checked_bytes(names));
  factors.looks = place.looks;
  factors.site_count = static_cast<std::uint32_t>(ids.size());
  factors.factors.resize(std::min(names.row_count, kMostFactors));
  SIGHTLINE_TRY(decode_factor_names(text.bytes(), factors));
  factors.values.resize(factors.shape().size(ids.size()));
  std::vector<bool> is_filled(ids.size());
  for (const FoundTile& tile : tiles) {
    const PackedBlock* layer = find_layer(tile, place.layer);
    if (layer == nullptr) continue;
    SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(*layer));
    const std::uint64_t rows =
        std::min<std::uint64_t>(layer->row_count, raw.bytes().size() / sizeof ids[0]);
    SIGHTLINE_TRY(decode_factor_layer(renumbered(raw.bytes(), rows, ids), layer->row_count, factors,
                                      is_filled));
  }
  if (std::ranges::find(is_filled, false) != is_filled.end()) {
    return Error{ErrorCode::kBadLayer, "some sites have none"};
  }
  return factors;
}

// Of the ranges, and of the looks that take a sample.
Result<void> decode_all_factors(const MapContainer& container, const std::vector<FoundTile>& tiles,
                                const SiteIds& ids, CompiledMap& map) {
  SIGHTLINE_ASSIGN(
      FactorTable factors,
      decode_factors(container, tiles, ids, {kFactorNames, kFactorLayer, map.ranges.looks}));
  if (factors.factors.empty()) return {};
  for (const RangeTable& ranges : map.ranges.of_samples) {
    SIGHTLINE_ASSIGN(FactorTable samples,
                     decode_factors(container, tiles, ids,
                                    {kSampleFactorNames, kSampleFactorLayer, ranges.looks}));
    if (!samples.factors.empty()) factors.of_samples.push_back(std::move(samples));
  }
  map.factors = std::move(factors);
  return {};
}

Result<void> decode_model(const MapContainer& container, CompiledMap& map) {
  const schema::Block* entry = find_section(container, kModelSection);
  if (entry == nullptr) return {};
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(packed_block(container, *entry)));
  if (sha256(raw.bytes()) != map.model.digest) {
    return Error{ErrorCode::kDigestMismatch, "it is not the one that the manifest names"};
  }
  map.model.bytes.assign(raw.bytes().begin(), raw.bytes().end());
  return {};
}

Result<void> decode_tile_drives(const MapContainer& container, CompiledMap& map) {
  const schema::Block* entry = find_section(container, kDrivesSection);
  if (entry == nullptr || !knows_drives_section(entry->version())) return {};
  SIGHTLINE_ASSIGN(const RawBytes raw, checked_bytes(packed_block(container, *entry)));
  SIGHTLINE_ASSIGN(map.tile_drives,
                   decode_drives(raw.bytes(), entry->version(), entry->row_count()));
  return {};
}

void tell(const std::string& what, const Result<void>& result, std::vector<std::string>& lost) {
  if (!result) lost.push_back(what + ": " + to_string(result.error()));
}

// What only the directory leads to.
void decode_for_engineers(const Result<MapContainer>& container,
                          const std::vector<FoundTile>& tiles, const SiteIds& ids,
                          Recovered& recovered) {
  if (!container) {
    recovered.lost.push_back(
        "the factors, the error model and the drives of each tile, if it had any: the directory is "
        "lost");
    return;
  }
  tell("the factors", decode_all_factors(*container, tiles, ids, recovered.map), recovered.lost);
  tell("the drives of each tile", decode_tile_drives(*container, recovered.map), recovered.lost);
  tell("the error model", decode_model(*container, recovered.map), recovered.lost);
}

void tell_counts(const schema::Manifest& manifest, const CompiledMap& map,
                 std::vector<std::string>& lost) {
  const std::uint64_t nds = map.ndt.nds.size();
  const std::uint64_t sites = map.sites.sites.size();
  if (nds == manifest.nd_count() && sites == manifest.site_count()) return;
  lost.push_back("kept " + std::to_string(sites) + " of " + std::to_string(manifest.site_count()) +
                 " sites and " + std::to_string(nds) + " of " +
                 std::to_string(manifest.nd_count()) + " NDs");
}

// It says no longer what held of the whole.
void mark_as_part(const SiteIds& ids, CompiledMap& map) {
  cut_runs(ids, map.sites);
  map.version += ", recovered";
  map.measurement.measured_site_count = 0;
  map.quality = quality_of(map, MeasuredError());
  map.look_quality = look_quality_of(map, MeasuredError());
}

}  // namespace

Result<Recovered> recover_map(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const MapFront front, open_front_alone(file));
  Recovered recovered;
  SIGHTLINE_TRY(decode_manifest(*front.manifest, recovered.map));
  const Result<MapContainer> container = open_directory(front);
  if (!container) recovered.lost.push_back("the directory: " + to_string(container.error()));
  std::vector<FoundTile> tiles =
      container ? tiles_of_directory(*container) : tiles_that_tell(front);
  std::erase_if(tiles, [&](const FoundTile& tile) {
    const Result<void> checked = check_tile(tile, *front.manifest);
    tell(tile_place(tile.key.x, tile.key.y), checked, recovered.lost);
    return !checked;
  });
  const SiteIds ids = sites_of(tiles);
  if (ids.empty()) {
    return Error{ErrorCode::kTruncatedFile, "no site is left in what can still be read"};
  }
  SIGHTLINE_TRY(decode_tiles(tiles, ids, recovered.map));
  decode_for_engineers(container, tiles, ids, recovered);
  const bool is_part = recovered.map.ndt.nds.size() != front.manifest->nd_count() ||
                       ids.size() != front.manifest->site_count();
  tell_counts(*front.manifest, recovered.map, recovered.lost);
  if (is_part) mark_as_part(ids, recovered.map);
  SIGHTLINE_TRY(validate(recovered.map));
  return recovered;
}

}  // namespace sightline
