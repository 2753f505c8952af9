#include "formats/map/map_writer.h"

#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/reader/map_layout.h"
#include "formats/reader/reader.h"

namespace sightline {
namespace {

// Flags go into the file as they are, and from there to the vehicle.
static_assert(kUnmet == kAnswerUnmet && kExtrapolated == kAnswerExtrapolated &&
              kStatic == kAnswerStatic && kSimulatedAnswer == kAnswerSimulated);

// None where the map holds no factors.
void append_factors(const FactorTable& factors, std::string_view name, const TileRows& rows,
                    TileParts& tile) {
  if (rows.sites.empty() || factors.factors.empty()) return;
  tile.layers.push_back({std::string(name), kFactorLayerVersion, false, rows.sites.size(), true,
                         encode_factor_layer(factors, rows.sites)});
}

void append_names(const FactorTable& factors, std::string_view name, ContainerParts& parts) {
  if (factors.factors.empty()) return;
  parts.sections.push_back({std::string(name), kFactorNamesVersion, false, factors.factors.size(),
                            true, encode_factor_names(factors)});
}

TileParts tile_parts(const CompiledMap& map, const TileRows& rows) {
  TileParts tile;
  tile.key = rows.key;
  append_factors(map.factors, kFactorLayer, rows, tile);
  for (const FactorTable& samples : map.factors.of_samples) {
    append_factors(samples, kSampleFactorLayer, rows, tile);
  }
  if (!rows.nds.empty()) {
    tile.layers.push_back({std::string(kNdtLayer), kNdtLayerVersion, true, rows.nds.size(), true,
                           encode_ndt_layer(map.ndt, rows.nds)});
  }
  if (!rows.sites.empty()) {
    // As it lies in memory, so that a vehicle needs no decompressor.
    tile.layers.push_back({std::string(kRangeLayer), kRangeLayerVersion, true, rows.sites.size(),
                           false, encode_range_layer(map, rows.sites)});
  }
  return tile;
}

// All but the tiles.
ContainerParts parts_without_tiles(const CompiledMap& map) {
  const Result<void> valid = validate(map);
  SIGHTLINE_CHECK(valid);
  ContainerParts parts;
  parts.manifest = encode_manifest(map);
  if (!map.model.bytes.empty()) {
    // The manifest names its digest, so it need not be required: a vehicle can do without it.
    parts.sections.push_back(
        {std::string(kModelSection), map.model.encoding_version, false, 1, true, map.model.bytes});
  }
  append_names(map.factors, kFactorNames, parts);
  for (const FactorTable& samples : map.factors.of_samples) {
    append_names(samples, kSampleFactorNames, parts);
  }
  return parts;
}

}  // namespace

ContainerParts parts_of(const CompiledMap& map) {
  ContainerParts parts = parts_without_tiles(map);
  for (const TileRows& rows : tiles_of(map)) parts.tiles.push_back(tile_parts(map, rows));
  return parts;
}

// Of a long street all tiles at once would be as large as the map in memory once more.
std::vector<std::byte> encode_map(const CompiledMap& map) {
  const std::vector<TileRows> tiles = tiles_of(map);
  return assemble(parts_without_tiles(map), tiles.size(),
                  [&](std::size_t i) { return tile_parts(map, tiles[i]); });
}

}  // namespace sightline
