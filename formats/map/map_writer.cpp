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
              kStatic == kAnswerStatic);

TileParts tile_parts(const CompiledMap& map, const TileRows& rows) {
  TileParts tile;
  tile.key = rows.key;
  if (!rows.sites.empty() && !map.factors.factors.empty()) {
    tile.layers.push_back({std::string(kFactorLayer), kFactorLayerVersion, false, rows.sites.size(),
                           true, encode_factor_layer(map.factors, rows.sites)});
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

}  // namespace

ContainerParts parts_of(const CompiledMap& map) {
  const Result<void> valid = validate(map);
  SIGHTLINE_CHECK(valid);
  ContainerParts parts;
  parts.manifest = encode_manifest(map);
  for (const TileRows& rows : tiles_of(map)) parts.tiles.push_back(tile_parts(map, rows));
  if (!map.model.bytes.empty()) {
    // The manifest names its digest, so it need not be required: a vehicle can do without it.
    parts.sections.push_back(
        {std::string(kModelSection), map.model.encoding_version, false, 1, true, map.model.bytes});
  }
  if (!map.factors.factors.empty()) {
    parts.sections.push_back({std::string(kFactorNames), kFactorNamesVersion, false,
                              map.factors.factors.size(), true, encode_factor_names(map.factors)});
  }
  return parts;
}

std::vector<std::byte> encode_map(const CompiledMap& map) { return assemble(parts_of(map)); }

}  // namespace sightline
