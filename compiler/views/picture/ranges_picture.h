#pragma once

#include <functional>
#include <string>

#include "compiler/views/picture/ndt_picture.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// Parts of a map drawn as SVG: 1 unit is 1 m; y grows downwards, so everything is drawn at -y.

// The box around all sites, wider by a margin on each side; {0, 0, 0, 0} where there are no sites.
MapBox box_of_route(const Sites& sites, double margin_m);

// The route at one limit: a path for each stretch of sites with the same range. `colour_of` takes
// an index into ranges.looks.
std::string route_svg(const Sites& sites, const RangeTable& ranges, std::size_t limit,
                      double width_m, const std::function<std::string(std::size_t)>& colour_of);

// A bar of a round length of about a quarter of the box's width, with its length above it, in the
// lower left corner of the box.
std::string scale_bar_svg(const MapBox& box, const std::string& colour);

// The part of the map that a picture of its ranges shows unless a box is named: 40 m around the
// route. {0, 0, 0, 0} where there are no sites.
MapBox ranges_picture_box(const Sites& sites);

// How far to look along the route, from above, for the tightest limit: the route coloured by range
// over the NDs that stand (grey; ground is left out, and of each column of cells one is drawn),
// black dots where no range is good enough, a scale bar and a legend in m below. Colours are spread
// over the ranges that the route takes. An SVG file: 1 unit is 1 m, north up, white paper. Only NDs
// with their mean in the box are drawn. The box must have an extent, and the table a limit.
std::string ranges_picture_svg(const NdtMap& map, const Sites& sites, const RangeTable& ranges,
                               const MapBox& box);

}  // namespace sightline
