#pragma once

#include <functional>
#include <string>

#include "compiler/views/picture/ndt_picture.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"

// Parts of a map drawn as SVG. 1 unit is 1 m; y grows downwards in SVG, so everything is drawn at
// -y.

namespace sightline {

// The box around all sites, wider by a margin on each side; {0, 0, 0, 0} where there are no sites.
MapBox box_of_route(const Sites& sites, double margin_m);

// The route at one limit: a path for each stretch of sites with the same range. `colour_of` takes
// an index into ranges.looks.
std::string route_svg(const Sites& sites, const RangeTable& ranges, std::size_t limit,
                      double width_m, const std::function<std::string(std::size_t)>& colour_of);

// A bar of a round length of about a quarter of the box's width, with its length above it, in the
// lower left corner of the box.
std::string scale_bar_svg(const MapBox& box, const std::string& colour);

}  // namespace sightline
