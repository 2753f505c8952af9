#include "compiler/views/picture/charts/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/text/numbers.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Margins of a chart around its plot and its legend.
constexpr double kLeft_px = 62.0;
constexpr double kRight_px = 14.0;
constexpr double kTop_px = 10.0;
constexpr double kBottom_px = 46.0;
// From a point to its label: clear of the largest point that another series may lay there.
constexpr double kLabelAside_px = 11.0;
constexpr double kLabelBelow_px = 15.0;
// The legend.
constexpr double kRow_px = 20.0;
constexpr double kCharacter_px = 6.9;  // of a sans-serif font of 12 px, on the wide side
constexpr double kKey_px = 22.0;       // an entry's mark
constexpr double kGap_px = 18.0;

constexpr double kSlack = 1e-9;  // of a step: a tick that rounding put beyond the end

std::string px(double value) { return fixed(value, 1); }

std::string stroke(const std::string& colour, double width_px, bool is_dashed) {
  return fmt::format(R"(style="fill:none;stroke:{};stroke-width:{:.1f}{}")", colour, width_px,
                     is_dashed ? ";stroke-dasharray:5 4" : "");
}

std::string rect(double left_px, double top_px, double width_px, double height_px,
                 const std::string& colour) {
  return fmt::format(
      R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" style="fill:{}"/>)"
      "\n",
      left_px, top_px, width_px, height_px, colour);
}

double round_step(double least_step) {
  const double power = std::pow(10.0, std::floor(std::log10(least_step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least_step * (1.0 - kSlack)) return factor * power;
  }
  return 10.0 * power;
}

struct LegendEntry {
  std::string name;
  std::string colour;
  Mark mark = Mark::kLine;
  bool is_dashed = false;
};

std::vector<LegendEntry> legend_entries(const Chart& chart) {
  std::vector<LegendEntry> entries;
  for (const ChartSeries& series : chart.series) {
    if (series.name.empty()) continue;
    entries.push_back({series.name, series.colour, series.mark, series.is_dashed});
  }
  if (!chart.band_name.empty()) {
    entries.push_back({chart.band_name, chart.band_colour, Mark::kBars, false});
  }
  return entries;
}

std::string draw_entry(const LegendEntry& entry, double x_px, double y_px) {
  std::string mark;
  if (entry.mark == Mark::kBars) {
    mark = fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="16" height="10" style="fill:{}"/>)",
                       x_px, y_px, entry.colour);
  } else if (entry.mark == Mark::kPoints) {
    mark = fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="4" style="fill:{}"/>)", x_px + 8.0,
                       y_px + 5.0, entry.colour);
  } else {
    mark = fmt::format(R"(<path d="M{:.1f} {:.1f}h16" {}/>)", x_px, y_px + 5.0,
                       stroke(entry.colour, 2.5, entry.is_dashed));
  }
  return mark + fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x_px + kKey_px,
                            y_px + 9.0, xml_text(entry.name));
}

struct Legend {
  std::string svg;
  double height_px = 0.0;
};

// Entries from left to right, in as many rows as they need; nothing where there is none.
Legend legend_of(const Chart& chart) {
  Legend legend;
  double left_px = kLeft_px;
  for (const LegendEntry& entry : legend_entries(chart)) {
    const double width_px = kKey_px + kCharacter_px * static_cast<double>(entry.name.size());
    const bool is_full = left_px > kLeft_px && left_px + width_px > chart.width_px - kRight_px;
    if (is_full) left_px = kLeft_px;
    if (is_full || legend.svg.empty()) legend.height_px += kRow_px;
    legend.svg += draw_entry(entry, left_px, kTop_px + legend.height_px - kRow_px);
    left_px += width_px + kGap_px;
  }
  return legend;
}

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
  double left_px = kLeft_px;
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
    text += fmt::format(R"(<path class="grid" d="M{:.1f} {:.1f}H{:.1f}"/>)"
                        R"(<text text-anchor="end" x="{:.1f}" y="{:.1f}">{}</text>)"
                        "\n",
                        plot.left_px, plot.at_y(tick), plot.right_px, plot.left_px - 6.0,
                        plot.at_y(tick) + 4.0, plot.y.label(tick));
  }
  for (const double tick : plot.x.ticks) {
    text += fmt::format(R"(<path class="axis" d="M{0:.1f} {1:.1f}v5"/>)"
                        R"(<text text-anchor="middle" x="{0:.1f}" y="{2:.1f}">{3}</text>)"
                        "\n",
                        plot.at_x(tick), plot.bottom_px, plot.bottom_px + 18.0, plot.x.label(tick));
  }
  return text +
         fmt::format(R"(<path class="axis" d="M{0:.1f} {1:.1f}V{2:.1f}H{3:.1f}"/>)"
                     R"(<text text-anchor="middle" x="{4:.1f}" y="{5:.1f}">{6}</text>)"
                     "<text text-anchor=\"middle\" transform=\"translate(14 {7:.1f}) rotate(-90)\">"
                     "{8}</text>\n",
                     plot.left_px, plot.top_px, plot.bottom_px, plot.right_px,
                     (plot.left_px + plot.right_px) / 2.0, chart.height_px - 8.0,
                     xml_text(chart.x_label), (plot.top_px + plot.bottom_px) / 2.0,
                     xml_text(chart.y_label));
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
      path += concat("H", px(point.x), "V", px(point.y));
    } else {
      path += concat((is_drawing ? "L" : "M"), px(point.x), " ", px(point.y));
    }
    is_drawing = true;
  }
  return concat("<path d=\"", path, "\" ", stroke(series.colour, series.size_px, series.is_dashed),
                "/>\n");
}

std::string draw_points(const ChartSeries& series, const Plot& plot) {
  std::string text;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double x_px = plot.at_x(series.x[i]);
    const double y_px = plot.at_y(series.y[i]);
    const double radius_px = i < series.sizes_px.size() ? series.sizes_px[i] : series.size_px;
    text += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" style="fill:{}"/>)", x_px,
                        y_px, radius_px, series.colour);
    if (i < series.labels.size()) {
      text += fmt::format(R"(<text class="small" x="{:.1f}" y="{:.1f}">{}</text>)",
                          x_px + kLabelAside_px, y_px + kLabelBelow_px, xml_text(series.labels[i]));
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
    text += rect(plot.at_x(series.x[i]) + shift_px, top_px, 0.94 * width_px,
                 plot.bottom_px - top_px, series.colour);
  }
  return text;
}

std::string draw_bands(const Chart& chart, const Plot& plot) {
  std::string text;
  for (const ChartBand& band : chart.bands) {
    const double from_px = plot.at_x(band.from_x);
    text += rect(from_px, plot.top_px, std::max(1.0, plot.at_x(band.to_x) - from_px),
                 plot.bottom_px - plot.top_px, chart.band_colour);
  }
  return text;
}

bool is_bars(const ChartSeries& series) { return series.mark == Mark::kBars; }

std::string draw_series(const Chart& chart, const Plot& plot) {
  const auto bar_count = static_cast<std::size_t>(std::ranges::count_if(chart.series, is_bars));
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
  if (std::ranges::any_of(chart.series, is_bars)) y.from = std::min(y.from, 0.0);
  x = {chart.least_x.value_or(x.from), chart.greatest_x.value_or(x.to)};
  y = {chart.least_y.value_or(y.from), chart.greatest_y.value_or(y.to)};
  Plot plot;
  plot.x = axis_of(x, 10, false);
  if (!chart.x_ticks.empty()) plot.x.ticks = chart.x_ticks;
  plot.y = axis_of(y, 6, !chart.greatest_y);
  plot.top_px = kTop_px + legend_px;
  plot.bottom_px = chart.height_px - kBottom_px;
  plot.right_px = chart.width_px - kRight_px;
  return plot;
}

// For scripts: left, right, top and bottom of the plot, then the numbers at its left and right.
std::string plot_text(const Plot& plot) {
  return fmt::format("{:.1f} {:.1f} {:.1f} {:.1f} {} {}", plot.left_px, plot.right_px, plot.top_px,
                     plot.bottom_px, format_double(plot.x.span.from),
                     format_double(plot.x.span.to));
}

}  // namespace

std::string Axis::label(double tick) const {
  const std::string text = fixed(tick, decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero ? "0" : text;
}

Axis axis_of(AxisSpan span, int tick_count, bool is_rounded) {
  if (!(span.to > span.from)) {
    const double half = span.from == 0.0 ? 0.5 : 0.05 * std::abs(span.from);
    span = {span.from - half, span.to + half};
  }
  const double step = round_step((span.to - span.from) / tick_count);
  if (is_rounded) {
    span = {step * std::floor(span.from / step + kSlack),
            step * std::ceil(span.to / step - kSlack)};
  }
  Axis axis;
  axis.span = span;
  axis.decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - kSlack)));
  const double first = std::ceil(span.from / step - kSlack);
  const double last = std::floor(span.to / step + kSlack);
  for (double i = first; i <= last; i += 1.0) axis.ticks.push_back(step * i);
  return axis;
}

std::string chart_svg(const Chart& chart) {
  const Legend legend = legend_of(chart);
  const Plot plot = plot_of(chart, legend.height_px);
  return concat(
      fmt::format(R"(<svg class="chart" role="img" viewBox="0 0 {:.1f} {:.1f}" data-plot="{}" )"
                  "font-size=\"12\" fill=\"currentColor\"><title>{}</title>\n",
                  chart.width_px, chart.height_px, plot_text(plot), xml_text(chart.title)),
      draw_bands(chart, plot), draw_axes(chart, plot), draw_series(chart, plot), legend.svg,
      "</svg>\n");
}

std::string chart_file_svg(const Chart& chart) {
  const std::string width = px(chart.width_px);
  const std::string height = px(chart.height_px);
  return concat("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", width, "\" height=\"", height,
                "\" font-family=\"sans-serif\">\n<style>.grid{fill:none;stroke:#dddddd}"
                ".axis{fill:none;stroke:#555555}.small{font-size:11px}</style>\n"
                "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
                chart_svg(chart), "</svg>\n");
}

}  // namespace sightline
