#pragma once

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"
#include "passes/map/places/field_limits.h"
#include "passes/pass/pass.h"

namespace sightline {

// Every place of a grid of spacing_m where a vehicle could stand and that it could reach from the
// largest stretch of such places, or from the place that options.from names, and the way that it
// looks there (schemas/definitions.md, "Everywhere" and "Heading"). A run is a row of the grid
// along x without a gap. Warns of how many places there are, about what annotating them takes, and
// of what is apart. Errors: no-ground (no place, or none near options.from), too-many-places,
// bad-value (numbers that from or within cannot hold).
Result<Sites> choose_field_sites(PassContext& ctx, const ChooseFieldSitesOptions& options,
                                 const TiledSurface& surface, const SensorProfile& sensor);
inline constexpr Pass kChooseFieldSites =
    Pass{"choose-field-sites", 1, "sites", "Places to annotate everywhere", &choose_field_sites}.in(
        Stage::kTiles);

}  // namespace sightline
