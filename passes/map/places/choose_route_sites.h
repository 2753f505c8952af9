#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/route.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ChooseRouteSitesOptions {
  double spacing_m = 1.0;
};
std::vector<OptionField> option_fields(ChooseRouteSitesOptions& options);

// Places every spacing_m along the lines of a route, each line a run of its own, and another one
// back where it is driven both ways. The vehicle stands level on the ground of the map and looks
// along the line; its sensor is height_m above the ground. A line with heights of a vehicle keeps
// them. Where the map has several floors, that of the line's height is taken, or without one that
// which goes on from a place where there is one floor alone. Left out, with a warning that counts
// them and names the first: places off the map (no surface within 20 m), without ground, farther
// than 3 m from any floor, or on floors that nothing distinguishes; a hole of at most 10 m in the
// ground is bridged. A place left out ends a run.
// Errors where no place is left: no-overlap (off the map; says how far away it is), no-ground,
// two-floors.
Result<Sites> choose_route_sites(PassContext& ctx, const ChooseRouteSitesOptions& options,
                                 const Route& route, const TiledSurface& surface,
                                 const SensorProfile& sensor);
inline constexpr Pass kChooseRouteSites =
    Pass{"choose-route-sites", 3, "sites", "Places to annotate along a route", &choose_route_sites}
        .in(Stage::kTiles);

}  // namespace sightline
