#pragma once

#include <string>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/tiled_surface.h"
#include "passes/pass/pass.h"

namespace sightline {

struct ChooseFieldSitesOptions {
  double spacing_m = 2.0;
  double width_m = 2.0;     // of a vehicle
  double height_m = 2.0;    // of it, above ground
  std::string from;         // "x, y" in world coordinates, m; empty: the largest stretch
  std::string within;       // "x0, y0, x1, y1" in world coordinates, m; empty: the whole map
  double memory_gib = 2.0;  // that annotating the places may take
  int most_places = 0;      // 0: as many as that memory holds
};
std::vector<OptionField> option_fields(ChooseFieldSitesOptions& options);

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
inline constexpr Pass kChooseFieldSites{"choose-field-sites", 1, "sites",
                                        "Places to annotate everywhere", &choose_field_sites};

}  // namespace sightline
