#pragma once

#include <vector>

#include "formats/foreign/maps/foreign_maps.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/pass/pass.h"

namespace sightline {

struct IngestNdMapOptions {
  double tile_m = 64.0;  // the map frame's origin is a multiple of it
  int min_points = 10;
};
std::vector<OptionField> option_fields(IngestNdMapOptions& options);

// The NDs of a finished NDT map as they are, in its own cells. The map frame begins at the multiple
// of tile_m at or below the lowest corner of all cells. Cells of too few points or without extent
// are left out, as build-ndt leaves them out, and counted in a warning; so is what open_apollo_map
// assumed. Errors: bad-value (a tile that is no multiple of the map's cell), empty-map (no valid
// cell), invalid-artifact (a map wider than a grid).
Result<NdtMap> ingest_nd_map(PassContext& ctx, const IngestNdMapOptions& options,
                             const ForeignNds& map);
inline constexpr Pass kIngestNdMap =
    Pass{"ingest-nd-map", 2, "nds", "NDs of a given NDT map", &ingest_nd_map}.in(Stage::kDrives);

}  // namespace sightline
