#pragma once

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"
#include "passes/map/places/field_options.h"
#include "passes/pass/pass.h"

namespace sightline {

// Every place of a grid of spacing_m where a vehicle could stand and that it could reach from the
// largest stretch of such places, or from the place that options.from names: on ground of the map,
// room around and above it (schemas/definitions.md, "Everywhere"). It stands level and looks the
// way, of 16, along which free ground extends farthest, ahead and behind together; one site a
// place, since a site answers whichever way a vehicle looks. A run is a row of the grid along x
// without a gap. Warns of how many places there are, about what annotating them takes, and of what
// is apart. Errors: no-ground (no place, or none near options.from), too-many-places, bad-value
// (numbers that from or within cannot hold).
Result<Sites> choose_field_sites(PassContext& ctx, const ChooseFieldSitesOptions& options,
                                 const TiledSurface& surface, const SensorProfile& sensor);
inline constexpr Pass kChooseFieldSites =
    Pass{"choose-field-sites", 1, "sites", "Places to annotate everywhere", &choose_field_sites}.in(
        Stage::kTiles);

}  // namespace sightline
