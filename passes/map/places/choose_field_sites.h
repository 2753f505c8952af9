#pragma once

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"
#include "passes/map/places/field_limits.h"
#include "passes/pass/pass.h"

namespace sightline {

// Every place of a grid of spacing_m where a vehicle could stand and that it could reach from the
// largest stretch of such places, or from options.from, with its heading there
// (schemas/definitions.md, "Everywhere" and "Heading"). A run is a row of the grid along x without
// a gap. Warns of the number of places, their cost, and of what is apart. Errors: no-ground (no
// place, or none near options.from), too-many-places, bad-value (`from` or `within`).
Result<Sites> choose_field_sites(PassContext& ctx, const ChooseFieldSitesOptions& options,
                                 const TiledSurface& surface, const SensorProfile& sensor);
inline constexpr Pass kChooseFieldSites =
    Pass{"choose-field-sites", 1, "sites", "Sites to annotate on all ground", &choose_field_sites}
        .in(Stage::kTiles);

}  // namespace sightline
