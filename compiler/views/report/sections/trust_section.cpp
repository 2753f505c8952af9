#include <cstdlib>

#include "compiler/views/picture/charts/calibration_chart.h"
#include "compiler/views/picture/charts/chart_svg.h"
#include "compiler/views/report/sections/sections.h"

// What was promised, what came of it, and how well held-out places are predicted.

namespace sightline {
namespace {

std::string promise_text(const LimitPromise& promise) {
  if (promise.is_earned) return percent(1.0 - promise.alpha) + " of the next drive";
  return promise.scope == PromiseScope::kNextDrive ? "not earned" : "none, of this drive";
}

std::string promises_table(const CompiledMap& map) {
  TextGrid grid = {{"limit", "promise", "p*", "blocks", "places", "drives", "expected coverage (%)",
                    "mean range (m)", "unmet (%)", "outside the model (%)"}};
  const auto sites = static_cast<double>(map.sites.sites.size());
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    const LimitPromise& promise = map.ranges.promises[limit];
    const LimitQuality& quality = map.quality[limit];
    grid.push_back({limit_text(promise.limit_m), promise_text(promise),
                    fixed(promise.probability_threshold, 3), std::to_string(promise.block_count),
                    std::to_string(promise.place_count), std::to_string(promise.drive_count),
                    in_percent(quality.expected_coverage), fixed(quality.mean_range_m, 1),
                    in_percent(quality.unmet_count / sites),
                    in_percent(quality.extrapolated_count / sites)});
  }
  return html_table(grid, "What the map promises");
}

std::string calibration(const Evaluation& evaluation) {
  const Chart chart = calibration_chart(evaluation, {kGrey, {kBlue, kOrange, kGreen}});
  return html_figure(
      {"calibration", "Calibration.",
       "All pairs of judged site and range, in tenths of what the map predicts: on the "
       "dashed line what is promised comes true, below it the map promises too much. The larger a "
       "point, the more pairs are behind it.",
       chart_svg(chart), ""});
}

std::string calibration_table(const Evaluation& evaluation) {
  TextGrid grid = {{"limit", "promised (%)", "observed (%)", "pairs of site and range"}};
  for (const ReliabilityBin& bin : evaluation.reliability) {
    grid.push_back({limit_text(bin.limit_m), in_percent(bin.promised), in_percent(bin.observed),
                    std::to_string(bin.count)});
  }
  return "<details><summary>The calibration curve's numbers</summary>\n" +
         html_table(grid, "Promised and observed, by tenths") + "</details>\n";
}

std::string prediction_table(const Evaluation& evaluation) {
  TextGrid grid = {{"range (m)"}, {"R²"}, {"RMSE (cm)"}};
  for (const StaticScore& score : evaluation.statics) {
    grid[0].push_back(fixed(score.range_m, 0));
    grid[1].push_back(fixed(score.r_squared, 2));
    grid[2].push_back(in_centimetres(score.rmse_m));
  }
  return html_table(grid, "Predicted against measured mean error on this drive");
}

}  // namespace

Section trust_section(const ReportSources& sources) {
  Section section = {"trust", "Can the promises be believed?", ""};
  section.html = promises_table(*sources.map);
  for (const LimitPromise& promise : sources.map->ranges.promises) {
    if (promise.statement.empty()) continue;
    section.html += paragraph(limit_text(promise.limit_m) + ": " + promise.statement);
  }
  if (sources.evaluation) {
    section.html += calibration(*sources.evaluation) + calibration_table(*sources.evaluation) +
                    prediction_table(*sources.evaluation);
  }
  return section;
}

}  // namespace sightline
