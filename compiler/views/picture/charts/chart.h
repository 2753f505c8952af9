#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sightline {

enum class Mark { kLine, kSteps, kPoints, kBars };

// One line, or one set of points or bars, of a chart.
struct ChartSeries {
  std::string name;    // in the legend; empty: not there
  std::string colour;  // any CSS colour
  Mark mark = Mark::kLine;
  double size_px = 1.6;  // width of a line, radius of a point; bars share the space
  bool is_dashed = false;
  std::vector<double> x = {};            // ascending for lines and steps
  std::vector<double> y = {};            // as many; a NaN breaks a line
  std::vector<std::string> labels = {};  // of points, shown beside them; empty, or as many
  std::vector<double> sizes_px = {};     // radius of each point; empty: size_px

  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
};

// A stretch of the x axis that is shaded.
struct ChartBand {
  double from_x = 0.0;
  double to_x = 0.0;
};

struct Chart {
  std::string title;    // for those who cannot see it
  std::string x_label;  // with its unit
  std::string y_label;
  double width_px = 760.0;
  double height_px = 300.0;
  std::vector<ChartSeries> series = {};
  std::vector<ChartBand> bands = {};
  std::string band_name = {};  // in the legend
  std::string band_colour = "#e0a0b0";
  std::vector<double> x_ticks = {};       // empty: chosen
  std::optional<double> least_y = {};     // else what the numbers need
  std::optional<double> greatest_y = {};  // what lies above is cut off
  std::optional<double> least_x = {};
  std::optional<double> greatest_x = {};
};

struct AxisSpan {
  double from = 0.0;
  double to = 1.0;
};

// One axis of a chart: numbers to shares of its length.
struct Axis {
  AxisSpan span;
  std::vector<double> ticks;  // ascending, within the span
  int decimals = 0;           // that tell the ticks apart

  [[nodiscard]] double share(double value) const {
    return (value - span.from) / (span.to - span.from);
  }
  [[nodiscard]] std::string label(double tick) const;
};

// Ticks at multiples of 1, 2 or 5 times a power of ten, about `tick_count` of them. `is_rounded`:
// the axis ends on ticks. A span of no extent is widened.
Axis axis_of(AxisSpan span, int tick_count, bool is_rounded);

// The chart as an SVG element that may stand in a page: axes with ticks and units, a legend, text
// and axes in the page's own colour. A line of more points than twice the pixels that it has keeps
// the least and the greatest of each column of pixels, so that no peak is lost. The element's
// data-plot says where the numbers lie: left, right, top and bottom of the plot in the viewBox,
// then the numbers at its left and right end.
std::string chart_svg(const Chart& chart);

// The same as a file of its own: black on white.
std::string chart_file_svg(const Chart& chart);

}  // namespace sightline
