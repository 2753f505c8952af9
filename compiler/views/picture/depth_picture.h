#pragma once

#include <cstddef>

#include "compiler/views/picture/raster.h"
#include "formats/surroundings/site_views.h"

namespace sightline {

// What a site sees, as a person would who stands there: map +x in the middle, +y to its left, up is
// up; one square of pixels a cell, near is warm and far is cold, grey is nothing within the longest
// range. Below it a scale from 0 to the longest range with a notch every 10 m. `site` is in bounds.
Raster depth_picture(const DepthImages& images, std::size_t site);

// The colour of a distance, for a scale that ends at longest_m.
Colour colour_of_distance(double distance_m, double longest_m);

}  // namespace sightline
