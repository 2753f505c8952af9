#pragma once

#include <string>

#include "formats/base/result.h"
#include "formats/geodesy.h"
#include "formats/map/diff/map_diff.h"

namespace sightline {

// All but the single NDs, as schemas/diff.schema.json describes it.
std::string to_json(const MapDiff& diff);

// For a geographic information system: every stretch as a line (a point where it has one site),
// every changed site and ND as a point, distinguished by the property "kind". Longitude, latitude
// and height where the world lies on Earth; else metres of the recording's own world, which the
// member "coordinate_frame" says. Error: bad-argument where a point is none of the world.
Result<std::string> to_geojson(const MapDiff& diff, const World& world);

}  // namespace sightline
