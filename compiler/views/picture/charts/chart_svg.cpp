#include "compiler/views/picture/charts/chart_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/views/picture/charts/chart_axis.h"
#include "compiler/views/picture/charts/chart_legend.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

constexpr double kBottom_px = 46.0;
// From a point to its label: clear of the largest point that another series may lay there.
constexpr double kLabelAside_px = 11.0;
constexpr double kLabelBelow_px = 15.0;

struct Point {
  double x = 0.0;
  double y = 0.0;
};

// Where numbers lie on the page.
struct Plot {
  Axis x;
  Axis y;
  double top_px = 0.0;
  double bottom_px = 0.0;
  double left_px = kChartLeft_px;
  double right_px = 0.0;

  [[nodiscard]] double at_x(double value) const {
    return left_px + x.share(value) * (right_px - left_px);
  }
  [[nodiscard]] double at_y(double value) const {
    return bottom_px - std::clamp(y.share(value), 0.0, 1.0) * (bottom_px - top_px);
  }
};

std::string draw_axes(const Chart& chart, const Plot& plot) {
  std::string text;
  for (const double tick : plot.y.ticks) {
    const std::string y = px(plot.at_y(tick));
    text += "<path class=\"grid\" d=\"M" + px(plot.left_px) + " " + y + "H" + px(plot.right_px) +
            "\"/><text text-anchor=\"end\" x=\"" + px(plot.left_px - 6.0) + "\" y=\"" +
            px(plot.at_y(tick) + 4.0) + "\">" + plot.y.label(tick) + "</text>\n";
  }
  for (const double tick : plot.x.ticks) {
    const std::string x = px(plot.at_x(tick));
    text += "<path class=\"axis\" d=\"M" + x + " " + px(plot.bottom_px) +
            "v5\"/><text text-anchor=\"middle\" x=\"" + x + "\" y=\"" + px(plot.bottom_px + 18.0) +
            "\">" + plot.x.label(tick) + "</text>\n";
  }
  const double middle_px = (plot.top_px + plot.bottom_px) / 2.0;
  return text + "<path class=\"axis\" d=\"M" + px(plot.left_px) + " " + px(plot.top_px) + "V" +
         px(plot.bottom_px) + "H" + px(plot.right_px) + "\"/><text text-anchor=\"middle\" x=\"" +
         px((plot.left_px + plot.right_px) / 2.0) + "\" y=\"" + px(chart.height_px - 8.0) + "\">" +
         xml_text(chart.x_label) + "</text><text text-anchor=\"middle\" transform=\"translate(14 " +
         px(middle_px) + ") rotate(-90)\">" + xml_text(chart.y_label) + "</text>\n";
}

// The least and the greatest of each column of pixels, in the order in which they come.
std::vector<Point> thinned(const std::vector<Point>& points) {
  std::vector<Point> kept;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin;
    const auto is_same_column = [&](const Point& point) {
      return std::floor(point.x) == std::floor(points[begin].x) && !std::isnan(point.y);
    };
    while (end < points.size() && is_same_column(points[end])) ++end;
    if (end == begin) {  // a break
      kept.push_back(points[begin++]);
      continue;
    }
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = points.begin() + static_cast<std::ptrdiff_t>(end);
    auto [low, high] =
        std::minmax_element(first, last, [](const Point& a, const Point& b) { return a.y < b.y; });
    if (high < low) std::swap(low, high);
    kept.push_back(*low);
    if (low != high) kept.push_back(*high);
    begin = end;
  }
  return kept;
}

std::string draw_line(const ChartSeries& series, const Plot& plot) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double y = std::isnan(series.y[i]) ? series.y[i] : plot.at_y(series.y[i]);
    points.push_back({plot.at_x(series.x[i]), y});
  }
  if (static_cast<double>(points.size()) > 2.0 * (plot.right_px - plot.left_px)) {
    points = thinned(points);
  }
  std::string path;
  bool is_drawing = false;
  for (const Point& point : points) {
    if (std::isnan(point.y)) {
      is_drawing = false;
      continue;
    }
    if (is_drawing && series.mark == Mark::kSteps) {
      path += "H" + px(point.x) + "V" + px(point.y);
    } else {
      path += (is_drawing ? "L" : "M") + px(point.x) + " " + px(point.y);
    }
    is_drawing = true;
  }
  return "<path d=\"" + path + "\" " +
         chart_stroke(series.colour, series.size_px, series.is_dashed) + "/>\n";
}

std::string draw_points(const ChartSeries& series, const Plot& plot) {
  std::string text;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double x_px = plot.at_x(series.x[i]);
    const double y_px = plot.at_y(series.y[i]);
    const double radius_px = i < series.sizes_px.size() ? series.sizes_px[i] : series.size_px;
    text += "<circle cx=\"" + px(x_px) + "\" cy=\"" + px(y_px) + "\" r=\"" + px(radius_px) +
            "\" style=\"fill:" + series.colour + "\"/>";
    if (i < series.labels.size()) {
      text += "<text class=\"small\" x=\"" + px(x_px + kLabelAside_px) + "\" y=\"" +
              px(y_px + kLabelBelow_px) + "\">" + xml_text(series.labels[i]) + "</text>";
    }
    text += "\n";
  }
  return text;
}

// `place` of `count` series of bars, which share three quarters of the space between two x.
std::string draw_bars(const ChartSeries& series, const Plot& plot, std::size_t place,
                      std::size_t count) {
  double step_px = plot.right_px - plot.left_px;
  for (std::size_t i = 1; i < series.x.size(); ++i) {
    step_px = std::min(step_px, plot.at_x(series.x[i]) - plot.at_x(series.x[i - 1]));
  }
  const double width_px = 0.75 * step_px / static_cast<double>(count);
  const double shift_px =
      width_px * (static_cast<double>(place) - static_cast<double>(count) / 2.0);
  std::string text;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double top_px = plot.at_y(series.y[i]);
    text += "<rect x=\"" + px(plot.at_x(series.x[i]) + shift_px) + "\" y=\"" + px(top_px) +
            "\" width=\"" + px(0.94 * width_px) + "\" height=\"" + px(plot.bottom_px - top_px) +
            "\" style=\"fill:" + series.colour + "\"/>\n";
  }
  return text;
}

std::string draw_bands(const Chart& chart, const Plot& plot) {
  std::string text;
  for (const ChartBand& band : chart.bands) {
    const double from_px = plot.at_x(band.from_x);
    text += "<rect x=\"" + px(from_px) + "\" y=\"" + px(plot.top_px) + "\" width=\"" +
            px(std::max(1.0, plot.at_x(band.to_x) - from_px)) + "\" height=\"" +
            px(plot.bottom_px - plot.top_px) + "\" style=\"fill:" + chart.band_colour + "\"/>\n";
  }
  return text;
}

std::string draw_series(const Chart& chart, const Plot& plot) {
  const auto is_bars = [](const ChartSeries& series) { return series.mark == Mark::kBars; };
  const auto bar_count =
      static_cast<std::size_t>(std::count_if(chart.series.begin(), chart.series.end(), is_bars));
  std::size_t bars = 0;
  std::string text;
  for (const ChartSeries& series : chart.series) {
    if (is_bars(series)) {
      text += draw_bars(series, plot, bars++, bar_count);
    } else {
      text += series.mark == Mark::kPoints ? draw_points(series, plot) : draw_line(series, plot);
    }
  }
  return text;
}

// The span of all numbers on one axis.
AxisSpan span_of(const Chart& chart, std::vector<double> ChartSeries::*numbers) {
  AxisSpan span = {std::numeric_limits<double>::infinity(),
                   -std::numeric_limits<double>::infinity()};
  for (const ChartSeries& series : chart.series) {
    for (const double number : series.*numbers) {
      if (!std::isfinite(number)) continue;
      span.from = std::min(span.from, number);
      span.to = std::max(span.to, number);
    }
  }
  if (span.from > span.to) span = {0.0, 1.0};
  return span;
}

Plot plot_of(const Chart& chart, double legend_px) {
  AxisSpan x = span_of(chart, &ChartSeries::x);
  AxisSpan y = span_of(chart, &ChartSeries::y);
  const auto has_bars = [](const ChartSeries& series) { return series.mark == Mark::kBars; };
  if (std::any_of(chart.series.begin(), chart.series.end(), has_bars)) {
    y.from = std::min(y.from, 0.0);
  }
  x = {chart.least_x.value_or(x.from), chart.greatest_x.value_or(x.to)};
  y = {chart.least_y.value_or(y.from), chart.greatest_y.value_or(y.to)};
  Plot plot;
  plot.x = axis_of(x, 10, false);
  if (!chart.x_ticks.empty()) plot.x.ticks = chart.x_ticks;
  plot.y = axis_of(y, 6, !chart.greatest_y);
  plot.top_px = kChartTop_px + legend_px;
  plot.bottom_px = chart.height_px - kBottom_px;
  plot.right_px = chart.width_px - kChartRight_px;
  return plot;
}

// For scripts: left, right, top and bottom of the plot, then the numbers at its left and right.
std::string plot_text(const Plot& plot) {
  std::string text;
  for (const double edge_px : {plot.left_px, plot.right_px, plot.top_px, plot.bottom_px}) {
    text += px(edge_px) + " ";
  }
  return text + format_double(plot.x.span.from) + " " + format_double(plot.x.span.to);
}

}  // namespace

std::string chart_svg(const Chart& chart) {
  const ChartLegend legend = legend_of(chart);
  const Plot plot = plot_of(chart, legend.height_px);
  return "<svg class=\"chart\" role=\"img\" viewBox=\"0 0 " + px(chart.width_px) + " " +
         px(chart.height_px) + "\" data-plot=\"" + plot_text(plot) +
         "\" font-size=\"12\" fill=\"currentColor\"><title>" + xml_text(chart.title) +
         "</title>\n" + draw_bands(chart, plot) + draw_axes(chart, plot) +
         draw_series(chart, plot) + legend.svg + "</svg>\n";
}

std::string chart_file_svg(const Chart& chart) {
  const std::string width = px(chart.width_px);
  const std::string height = px(chart.height_px);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
         "\" font-family=\"sans-serif\">\n<style>.grid{fill:none;stroke:#dddddd}"
         ".axis{fill:none;stroke:#555555}.small{font-size:11px}</style>\n"
         "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" +
         chart_svg(chart) + "</svg>\n";
}

}  // namespace sightline
