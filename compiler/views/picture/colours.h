#pragma once

#include <cstddef>
#include <string>

#include "compiler/views/picture/raster.h"

namespace sightline {

// matplotlib's viridis (public domain), which rises in brightness from 0, dark violet, to 1,
// yellow, and reads the same to colour-blind people.
Colour viridis(double share);

// The colour of the index-th of `count` ranges, near to far, on white paper: from violet to a
// yellow green that is still seen.
Colour range_colour_on_paper(std::size_t index, std::size_t count);

// As CSS and SVG write it: "#1e5ac8".
std::string colour_name(const Colour& colour);

}  // namespace sightline
