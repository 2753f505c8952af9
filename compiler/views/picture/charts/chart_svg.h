#pragma once

#include <string>

#include "compiler/views/picture/charts/chart.h"

namespace sightline {

// The chart as an SVG element that may stand in a page: axes with ticks and units, a legend, text
// and axes in the page's own colour. A line of more points than twice the pixels that it has keeps
// the least and the greatest of each column of pixels, so that no peak is lost. The element's
// data-plot says where the numbers lie: left, right, top and bottom of the plot in the viewBox,
// then the numbers at its left and right end.
std::string chart_svg(const Chart& chart);

// The same as a file of its own: black on white.
std::string chart_file_svg(const Chart& chart);

}  // namespace sightline
