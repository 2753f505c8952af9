#include "compiler/views/picture/charts/calibration_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sightline {
namespace {

constexpr double kLargest_px = 9.0;   // radius of the point with most pairs
constexpr double kSmallest_px = 2.0;  // of one with next to none, so that it can be seen

std::string name_of(double limit_m) { return fmt::format("within {:g} cm", 100.0 * limit_m); }

// The curve, and its points.
void add_limit(const std::vector<ReliabilityBin>& bins, ChartSeries line, Chart& chart) {
  ChartSeries points = line;
  points.mark = Mark::kPoints;
  line.name.clear();
  std::uint32_t most = 1;
  for (const ReliabilityBin& bin : bins) most = std::max(most, bin.count);
  for (const ReliabilityBin& bin : bins) {
    points.x.push_back(100.0 * bin.promised);
    points.y.push_back(100.0 * bin.observed);
    points.sizes_px.push_back(
        std::max(kSmallest_px, kLargest_px * std::sqrt(bin.count / double(most))));
  }
  line.x = points.x;
  line.y = points.y;
  chart.series.push_back(std::move(line));
  chart.series.push_back(std::move(points));
}

}  // namespace

Chart calibration_chart(const Evaluation& evaluation, const CalibrationColours& colours) {
  Chart chart;
  chart.title = "Promised against observed share within the limit";
  chart.x_label = "predicted P(error within the limit) (%)";
  chart.y_label = "observed share (%)";
  chart.width_px = 480.0;
  chart.height_px = 440.0;
  chart.least_x = chart.least_y = 0.0;
  chart.greatest_x = chart.greatest_y = 100.0;
  ChartSeries diagonal;
  diagonal.name = "as promised";
  diagonal.colour = colours.promise;
  diagonal.x = diagonal.y = {0.0, 100.0};
  diagonal.is_dashed = true;
  chart.series.push_back(std::move(diagonal));
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    std::vector<ReliabilityBin> bins;
    std::ranges::copy_if(
        evaluation.reliability, std::back_inserter(bins),
        [&](const ReliabilityBin& bin) { return bin.limit_m == evaluation.limits_m[limit]; });
    ChartSeries line;
    line.name = name_of(evaluation.limits_m[limit]);
    line.colour = colours.of_limits[limit % colours.of_limits.size()];
    line.size_px = 2.0;
    add_limit(bins, std::move(line), chart);
  }
  return chart;
}

}  // namespace sightline
