#include "compiler/views/picture/charts/calibration_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sightline {
namespace {

constexpr double kLargest_px = 9.0;   // radius of the point with most pairs
constexpr double kSmallest_px = 2.0;  // of one with next to none, so that it can be seen

void add_limit(const std::vector<ReliabilityBin>& bins, ChartSeries line, Chart& chart) {
  ChartSeries points = line;
  points.mark = Mark::kPoints;
  line.name.clear();
  std::uint32_t most = 1;
  for (const ReliabilityBin& bin : bins) most = std::max(most, bin.count);
  for (const ReliabilityBin& bin : bins) {
    points.add(100.0 * bin.promised, 100.0 * bin.observed);
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
  Chart chart = {"Predicted and observed share within the limit",
                 "predicted P(error within the limit) (%)", "observed share (%)", 480.0, 440.0};
  chart.least_x = chart.least_y = 0.0;
  chart.greatest_x = chart.greatest_y = 100.0;
  const std::vector<double> ends = {0.0, 100.0};
  chart.series = {{"exact prediction", colours.promise, Mark::kLine, 1.6, true, ends, ends}};
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    const double limit_m = evaluation.limits_m[limit];
    std::vector<ReliabilityBin> bins;
    std::ranges::copy_if(evaluation.reliability, std::back_inserter(bins),
                         [&](const ReliabilityBin& bin) { return bin.limit_m == limit_m; });
    const std::string& colour = colours.of_limits[limit % colours.of_limits.size()];
    add_limit(bins, {fmt::format("within {:g} cm", 100.0 * limit_m), colour, Mark::kLine, 2.0},
              chart);
  }
  return chart;
}

}  // namespace sightline
