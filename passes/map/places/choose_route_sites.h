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

// Places every spacing_m along the lines of a route, each line a run, and another one back where it
// is driven both ways ("Places" in schemas/definitions.md, "Annotating a finished map"). The
// vehicle stands level on the ground and looks along the line; its sensor is height_m above the
// ground. A place that is left out ends a run and is counted in a warning. Errors where no place is
// left: no-overlap (off the map; says how far away it is), no-ground, two-floors.
Result<Sites> choose_route_sites(PassContext& ctx, const ChooseRouteSitesOptions& options,
                                 const Route& route, const TiledSurface& surface,
                                 const SensorProfile& sensor);
inline constexpr Pass kChooseRouteSites =
    Pass{"choose-route-sites", 3, "sites", "Sites to annotate along a route", &choose_route_sites}
        .in(Stage::kTiles);

}  // namespace sightline
