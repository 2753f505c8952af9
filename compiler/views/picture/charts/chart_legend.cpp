#include "compiler/views/picture/charts/chart_legend.h"

#include <vector>

#include "formats/text/numbers.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

constexpr double kRow_px = 20.0;
constexpr double kCharacter_px = 6.9;  // of a sans-serif font of 12 px, on the wide side
constexpr double kKey_px = 22.0;       // an entry's mark
constexpr double kGap_px = 18.0;

struct LegendEntry {
  std::string name;
  std::string colour;
  Mark mark = Mark::kLine;
  bool is_dashed = false;
  double left_px = 0.0;
  double row = 0.0;
};

// Entries from left to right, in as many rows as they need.
std::vector<LegendEntry> entries_of(const Chart& chart) {
  std::vector<LegendEntry> entries;
  for (const ChartSeries& series : chart.series) {
    if (!series.name.empty()) {
      entries.push_back({series.name, series.colour, series.mark, series.is_dashed, 0.0, 0.0});
    }
  }
  if (!chart.band_name.empty()) {
    entries.push_back({chart.band_name, chart.band_colour, Mark::kBars, false, 0.0, 0.0});
  }
  double left_px = kChartLeft_px;
  double row = 0.0;
  for (LegendEntry& entry : entries) {
    const double width_px = kKey_px + kCharacter_px * static_cast<double>(entry.name.size());
    if (left_px > kChartLeft_px && left_px + width_px > chart.width_px - kChartRight_px) {
      left_px = kChartLeft_px;
      row += 1.0;
    }
    entry.left_px = left_px;
    entry.row = row;
    left_px += width_px + kGap_px;
  }
  return entries;
}

std::string draw_legend(const std::vector<LegendEntry>& entries) {
  std::string text;
  for (const LegendEntry& entry : entries) {
    const double y_px = kChartTop_px + kRow_px * entry.row;
    const std::string left = px(entry.left_px);
    if (entry.mark == Mark::kBars) {
      text += "<rect x=\"" + left + "\" y=\"" + px(y_px) +
              "\" width=\"16\" height=\"10\" style=\"fill:" + entry.colour + "\"/>";
    } else if (entry.mark == Mark::kPoints) {
      text += "<circle cx=\"" + px(entry.left_px + 8.0) + "\" cy=\"" + px(y_px + 5.0) +
              "\" r=\"4\" style=\"fill:" + entry.colour + "\"/>";
    } else {
      text += "<path d=\"M" + left + " " + px(y_px + 5.0) + "h16\" " +
              chart_stroke(entry.colour, 2.5, entry.is_dashed) + "/>";
    }
    text += "<text x=\"" + px(entry.left_px + kKey_px) + "\" y=\"" + px(y_px + 9.0) + "\">" +
            xml_text(entry.name) + "</text>\n";
  }
  return text;
}

}  // namespace

std::string px(double value) { return fixed(value, 1); }

std::string chart_stroke(const std::string& colour, double width_px, bool is_dashed) {
  return "style=\"fill:none;stroke:" + colour + ";stroke-width:" + px(width_px) +
         (is_dashed ? ";stroke-dasharray:5 4\"" : "\"");
}

ChartLegend legend_of(const Chart& chart) {
  const std::vector<LegendEntry> entries = entries_of(chart);
  const double rows = entries.empty() ? 0.0 : entries.back().row + 1.0;
  return {draw_legend(entries), kRow_px * rows};
}

}  // namespace sightline
