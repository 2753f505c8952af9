#pragma once

#include <string>

#include "compiler/views/picture/charts/chart.h"

namespace sightline {

// Margins of a chart around its plot and its legend.
inline constexpr double kChartLeft_px = 62.0;
inline constexpr double kChartRight_px = 14.0;
inline constexpr double kChartTop_px = 10.0;

struct ChartLegend {
  std::string svg;
  double height_px = 0.0;
};

// The names of the series and of the bands from left to right, in as many rows as they need;
// nothing where none has a name.
ChartLegend legend_of(const Chart& chart);

// How SVG writes a length, and the style of a line.
std::string px(double value);
std::string chart_stroke(const std::string& colour, double width_px, bool is_dashed);

}  // namespace sightline
