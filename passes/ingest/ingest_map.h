#pragma once

#include <vector>

#include "formats/foreign/maps/foreign_maps.h"
#include "formats/map/compiled_map.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass.h"

namespace sightline {

struct IngestMapOptions {
  double tile_m = 64.0;  // the map frame's origin is a multiple of it
};
std::vector<OptionField> option_fields(IngestMapOptions& options);

// The points of a finished map, taken for what stood still; read again piece by piece, as those of
// a drive are. The map frame begins at the multiple of tile_m at or below the lowest corner of all
// points, so that cells are those of any map in these coordinates. Warns of points dropped (not
// finite, at zero, withheld), of what open_point_map assumed, and of a thin map: of how many points
// it has on each square metre of surface, and what that costs. Errors: invalid-artifact (a map
// wider than a grid), and those of point_map_store.
Result<SurfacePoints> ingest_map(PassContext& ctx, const IngestMapOptions& options,
                                 const PointMap& map);
inline constexpr Pass kIngestMap =
    Pass{"ingest-map", 1, "points", "Points of a finished map", &ingest_map}.in(Stage::kDrives);

// Points on a square metre of surface that cells and patches need (schemas/definitions.md,
// "Annotating a finished map"): 10 in a cell of 2 m, 3 in one of 0.5 m.
inline constexpr double kDenseForNds = 2.5;
inline constexpr double kDenseForSurface = 12.0;

// After decode: gives the points back the pieces that they are read from.
void reattach(SurfacePoints& points, const PointMap& map);

// The NDs of a compiled map as they are, to annotate it anew.
Result<NdtMap> ingest_compiled_map(PassContext& ctx, const NoOptions& options,
                                   const CompiledMap& map);
inline constexpr Pass kIngestCompiledMap =
    Pass{"ingest-compiled-map", 1, "nds", "NDs of a compiled map", &ingest_compiled_map}.in(
        Stage::kDrives);

}  // namespace sightline
