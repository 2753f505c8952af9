#include "formats/map/map_writer.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "formats/map/drives_section.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_layout.h"
#include "formats/reader/reader.h"

namespace sightline {
namespace {

// Flags go into the file as they are, and from there to the vehicle.
static_assert(kUnmet == kAnswerUnmet && kExtrapolated == kAnswerExtrapolated &&
              kStatic == kAnswerStatic && kSimulatedAnswer == kAnswerSimulated);

// What a tile holds but for its NDs, by name of layer. `encode_factors`: of a table at those sites.
template <class EncodeFactors>
std::vector<BlockParts> layers_of_sites(const CompiledMap& map,
                                        const ByFamily<const FactorTable*>& factors,
                                        std::span<const std::uint32_t> sites,
                                        const EncodeFactors& encode_factors) {
  std::vector<BlockParts> layers;
  if (sites.empty()) return layers;
  const auto append = [&](const FactorTable& table, std::string_view name) {
    if (table.factors.empty()) return;
    layers.push_back({std::string(name), kFactorLayerVersion, false, sites.size(), true,
                      encode_factors(table, sites)});
  };
  append(*factors.ranges, kFactorLayer);
  if (factors.samples) append(**factors.samples, kSampleFactorLayer);
  layers.push_back({std::string(kRangeLayer), kRangeLayerVersion, true, sites.size(), false,
                    encode_range_layer(map, sites)});
  if (map.size == MapSize::kPromise) {
    layers.back().stored = store_range_layer(layers.back().raw, sites.size(), answer_shape(map));
  }
  return layers;
}

TileParts tile_parts(const CompiledMap& map, const TileRows& rows) {
  TileParts tile{rows.key, layers_of_sites(map, factors_in(map), rows.sites, encode_factor_layer)};
  if (!rows.nds.empty()) {
    tile.layers.push_back({std::string(kNdtLayer), kNdtLayerVersion, true, rows.nds.size(), true,
                           encode_ndt_layer(map.ndt, rows.nds)});
    if (map.size == MapSize::kPromise) {
      tile.layers.back().stored =
          store_ndt_layer(tile.layers.back().raw, rows.nds.size(), map.ndt.cell_m, map.size);
    }
  }
  std::ranges::sort(tile.layers, {}, &BlockParts::name);
  return tile;
}

// Names of factors.
std::vector<BlockParts> sections_of(const ByFamily<const FactorTable*>& factors) {
  std::vector<BlockParts> sections;
  const auto append = [&](const FactorTable& table, std::string_view name) {
    if (table.factors.empty()) return;
    sections.push_back({std::string(name), kFactorNamesVersion, false, table.factors.size(), true,
                        encode_factor_names(table)});
  };
  append(*factors.ranges, kFactorNames);
  if (factors.samples) append(**factors.samples, kSampleFactorNames);
  return sections;
}

// Which drives each tile is from; none where one alone made the map.
std::vector<BlockParts> sections_of(const std::optional<TileDrives>& tile_drives) {
  if (!tile_drives) return {};
  return {{std::string(kDrivesSection), kDrivesSectionVersion, false, tile_drives->rows.size(),
           true, encode_drives(*tile_drives)}};
}

// What the map and its errors were made from.
std::vector<BlockParts> sections_of(const std::optional<RecordingCards>& recordings) {
  if (!recordings) return {};
  return {{std::string(kRecordingsSection), kRecordingsSectionVersion, false,
           recordings->cards.size(), true, encode_recordings(*recordings)}};
}

// As they are in memory, so that a vehicle needs no decompressor.
std::vector<BlockParts> sections_of(const std::vector<SiteColumn>& columns) {
  std::vector<BlockParts> sections;
  for (const SiteColumn& column : columns) {
    sections.push_back({column_section(column.name), column_version(!column.steps.empty()), false,
                        column.values.size(), false, encode_column(column)});
  }
  return sections;
}

// All but the model. `factors` may be without values.
std::vector<BlockParts> sections_of(const CompiledMap& map,
                                    const ByFamily<const FactorTable*>& factors) {
  std::vector<BlockParts> sections = sections_of(factors);
  std::ranges::move(sections_of(map.tile_drives), std::back_inserter(sections));
  std::ranges::move(sections_of(map.recordings), std::back_inserter(sections));
  std::ranges::move(sections_of(map.columns), std::back_inserter(sections));
  return sections;
}

void append_values(const FactorTable& some, FactorTable& rows) {
  rows.site_count += some.site_count;
  rows.values.insert(rows.values.end(), some.values.begin(), some.values.end());
}

// The factors of these sites alone, which ascend.
Result<FactorTable> factors_at(const StoredTable<FactorTable>& factors,
                               std::span<const std::uint32_t> sites) {
  SIGHTLINE_ASSIGN(FactorTable rows, factors.rows(0, 0));
  if (rows.factors.empty()) return rows;
  for (std::size_t i = 0; i < sites.size();) {
    std::size_t end = i + 1;
    while (end < sites.size() && sites[end] == sites[end - 1] + 1) ++end;
    SIGHTLINE_ASSIGN(const FactorTable some, factors.rows(sites[i], end - i));
    append_values(some, rows);
    i = end;
  }
  return rows;
}

// Sites and NDs of a tile, either of which may be missing.
struct TileOfParts {
  const std::vector<std::uint32_t>* sites = nullptr;
  const PackedNdTile* nds = nullptr;
};

Result<void> write_tile(TileKey key, const TileOfParts& tile, const MapParts& parts,
                        ContainerWriter& writer) {
  std::vector<SelfContainedBlock> own;
  if (tile.sites != nullptr) {
    const auto at_sites = [&](const StoredTable<FactorTable>& table) {
      return factors_at(table, *tile.sites);
    };
    SIGHTLINE_ASSIGN(const ByFamily<FactorTable> here, each_family(at_sites, parts.factors));
    ByFamily<const FactorTable*> factors(&here.ranges);
    if (here.samples) factors.samples = &*here.samples;
    for (const BlockParts& layer :
         layers_of_sites(parts.answers, factors, *tile.sites, encode_factor_rows)) {
      own.push_back(packed(layer));
    }
  }
  std::vector<PackedBlock> layers;
  for (const SelfContainedBlock& layer : own) layers.push_back(layer.block);
  std::vector<std::byte> bytes;
  if (tile.nds != nullptr) {
    SIGHTLINE_ASSIGN(PackedBlock nds, read_layer(parts.nds, *tile.nds, bytes));
    layers.push_back(std::move(nds));
  }
  std::ranges::sort(layers, {}, &PackedBlock::name);
  return writer.add_tile(key, layers);
}

}  // namespace

ContainerParts parts_of(const CompiledMap& map) {
  SIGHTLINE_CHECK(validate(map));
  ContainerParts parts;
  parts.manifest = encode_manifest(map);
  parts.sections = sections_of(map, factors_in(map));
  if (!map.model.bytes.empty()) {
    parts.sections.push_back(
        {std::string(kModelSection), map.model.encoding_version, false, 1, true, map.model.bytes});
  }
  std::ranges::sort(parts.sections, {}, &BlockParts::name);
  for (const TileRows& rows : tiles_of(map)) parts.tiles.push_back(tile_parts(map, rows));
  return parts;
}

Result<void> validate_factors(const ByFamily<StoredTable<FactorTable>>& factors,
                              const CompiledMap& map) {
  SIGHTLINE_TRY(validate_factors(heads_of(factors), map));
  const bool has_factors = !factors.ranges.head().factors.empty();
  return has_factors ? validate(factors) : Result<void>();
}

Result<void> write_map(const MapParts& parts, const ContainerWriter::Write& write) {
  const CompiledMap& map = parts.answers;
  SIGHTLINE_CHECK(map.ndt.nds.empty() && map.factors.factors.empty() && map.model.bytes.empty());
  SIGHTLINE_CHECK(map.model == parts.model.record);
  SIGHTLINE_CHECK(validate(map));
  SIGHTLINE_CHECK(validate_factors(parts.factors, map));
  const std::vector<TileRows> of_sites = tiles_of(map);
  std::map<TileKey, TileOfParts> tiles;
  for (const TileRows& rows : of_sites) tiles[rows.key].sites = &rows.sites;
  for (const PackedNdTile& tile : parts.nds.tiles) tiles[tile.key].nds = &tile;
  ContainerWriter writer(write, encode_manifest(map, parts.nds.nd_count), {});
  for (const auto& [key, tile] : tiles) SIGHTLINE_TRY(write_tile(key, tile, parts, writer));
  std::vector<std::byte> bytes;
  SIGHTLINE_ASSIGN(PackedBlock model, read_section(parts.model, bytes));
  std::vector<SelfContainedBlock> own;
  for (const BlockParts& section : sections_of(map, heads_of(parts.factors)))
    own.push_back(packed(section));
  std::vector<PackedBlock> sections = {std::move(model)};
  for (const SelfContainedBlock& section : own) sections.push_back(section.block);
  std::ranges::sort(sections, {}, &PackedBlock::name);
  for (const PackedBlock& section : sections) SIGHTLINE_TRY(writer.add_section(section));
  SIGHTLINE_ASSIGN([[maybe_unused]] const Digest root, writer.finish());
  return {};
}

std::vector<std::byte> encode_map(const CompiledMap& map) { return assemble(parts_of(map)); }

}  // namespace sightline
