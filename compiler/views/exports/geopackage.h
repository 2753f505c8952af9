#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "compiler/views/picture/raster.h"
#include "formats/geodesy.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// The route as an OGC GeoPackage 1.3: layer `sites` (points with site_properties()), layer `route`
// (a line for each stretch of one recommended answer and one range for the first limit), and in
// `layer_styles` the styles that QGIS opens them with: the route coloured by answer, sites by
// range. In UTM or MGRS the coordinates are easting and northing of the zone, in an ENU world
// longitude and latitude, in a local one metres of an undefined Cartesian system. The same map
// gives the same bytes with the same SQLite. Errors: bad-argument (a site is no point of the
// world), out-of-memory.
Result<std::vector<std::byte>> to_geopackage(const CompiledMap& map, const World& world);

// A value of an attribute, its words in the legend, and its colour.
struct QgisClass {
  std::string value;
  std::string label;
  Colour colour;
};

// A style of QGIS 3 (QML): symbols of a type ("marker" or "line") coloured by the value of an
// attribute.
std::string qgis_style(const std::string& type, const std::string& attribute,
                       const std::vector<QgisClass>& classes);

// The same for an attribute that is a range: symbols of a type ("marker" or "line") coloured by the
// value of an attribute, one class for each range.
std::string qgis_range_style(const std::string& type, const std::string& attribute,
                             const std::vector<double>& ranges_m);

}  // namespace sightline
