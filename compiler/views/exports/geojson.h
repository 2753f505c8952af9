#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "formats/base/result.h"
#include "formats/geodesy.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// What a GIS gets of a site: its number, run and place along it, and for each limit
// ("..._within_10_cm") range, probability, error, flags and, where a map has them, the look; then
// the map's columns. The same names in the same order at every site of a map.
using SiteProperty = std::variant<bool, std::int64_t, double, std::string>;
std::vector<std::pair<std::string, SiteProperty>> site_properties(const CompiledMap& map,
                                                                  std::size_t site);

// "range_m_within_10_cm"
std::string range_property(const CompiledMap& map, std::size_t limit);

// A position as GeoJSON wants it: longitude and latitude in degrees, to nine decimals, and altitude
// where the world is known, else the world coordinates, m. Error: bad-argument (no point of the
// world).
using GeoPosition = std::array<double, 3>;
Result<GeoPosition> geo_position(const World& world, const Eigen::Vector3d& p_world_m);

// A FeatureCollection (RFC 7946): a Point for each site with its range, probability and flags for
// each limit, and a LineString for each run. Longitude, latitude and altitude where the world is
// known; else world coordinates in metres, with a member "crs" that says so (RFC 7946 knows degrees
// alone; GDAL and QGIS read it). Ends in a newline. Error: bad-argument (a site is no point of the
// world named).
Result<std::string> to_geojson(const CompiledMap& map, const World& world);

}  // namespace sightline
