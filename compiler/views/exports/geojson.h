#pragma once

#include <string>

#include "formats/geodesy.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// A FeatureCollection (RFC 7946): a Point for each site with its range, probability and flags for
// each limit, and a LineString for each run. Longitude, latitude and altitude where the world is
// known; else world coordinates in metres, with a member "crs" that says so (RFC 7946 knows degrees
// alone; GDAL and QGIS read it). Ends in a newline. Error: bad-argument (a site is no point of the
// world named).
Result<std::string> to_geojson(const CompiledMap& map, const World& world);

}  // namespace sightline
