#include <algorithm>

#include "compiler/views/report/sections/along.h"
#include "compiler/views/report/sections/sections.h"
#include "formats/grid/site_shape.h"

namespace sightline {
namespace {

std::string table_one(const Evaluation& evaluation) {
  TextGrid rows = {{"range (m)", "mean error (cm)", "mean matching time (ms)",
                    "longest mean time of a site (ms)", "longest time of one match (ms)",
                    "mean time relative to the longest range",
                    "work relative to the longest range"}};
  const StaticScore& longest = evaluation.statics.back();
  const auto ratio = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
  for (const StaticScore& score : evaluation.statics) {
    rows.push_back({fixed(score.range_m, 0), in_centimetres(score.mean_error_m),
                    fixed(score.mean_time_ms, 2), fixed(score.max_site_time_ms, 2),
                    fixed(score.max_run_time_ms, 2),
                    fixed(ratio(score.mean_time_ms, longest.mean_time_ms), 2),
                    fixed(ratio(score.mean_work, longest.mean_work), 2)});
  }
  return html_table(transposed(rows),
                    concat("Table I. Error and matching time of each static range: means over ",
                           evaluation.sites.size(), " sites"));
}

// Lines across the chart at the limits, with room above them; larger errors are on the upper edge.
void mark_limits(const Evaluation& evaluation, Chart& chart) {
  constexpr double kOfGreatestLimit = 4.0;
  const std::vector<double> along_m = chart.series.front().x;
  double greatest_cm = 0.0;
  for (const double error_m : evaluation.error_m) {
    greatest_cm = std::max(greatest_cm, 100.0 * error_m);
  }
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    const double limit_cm = 100.0 * evaluation.limits_m[limit];
    chart.series.push_back({"limit " + limit_text(evaluation.limits_m[limit]),
                            limit_colour(limit),
                            Mark::kLine,
                            1.6,
                            true,
                            {along_m.front(), along_m.back()},
                            {limit_cm, limit_cm}});
    chart.greatest_y.reset();
    const double room_cm = kOfGreatestLimit * limit_cm;
    if (greatest_cm > room_cm) chart.greatest_y = room_cm;
  }
}

std::string figure_five(const Evaluation& evaluation, const Sites& sites) {
  const Along along(evaluation, sites);
  Chart chart =
      route_chart("Localization error along the route at each range", "localization error (cm)");
  const SiteShape shape{evaluation.statics.size()};
  for (std::size_t range = 0; range < shape.rows; ++range) {
    chart.series.push_back(along.series(
        metres(evaluation.statics[range].range_m), range_colour(range),
        [&](std::size_t i) { return 100.0 * evaluation.error_m[shape.index(i, range)]; }));
    chart.series.back().size_px = 1.2;
  }
  mark_limits(evaluation, chart);
  return html_figure({"figure-5", "Error by range.",
                      "Mean localization error along the route, one line for each static range. "
                      "Short ranges have larger errors where few structures are near. Dashed lines "
                      "are the limits; larger errors are cut off at the upper edge.",
                      chart_svg(chart), "error-along"});
}

std::string figure_six(const Evaluation& evaluation) {
  Chart chart = {"Mean and longest matching time of each range", "observation range (m)",
                 "matching time (ms)"};
  ChartSeries mean = {"mean over sites", kBlue, Mark::kBars};
  ChartSeries most = {"longest mean time of a site", kOrange, Mark::kBars};
  for (const StaticScore& score : evaluation.statics) {
    mean.add(score.range_m, score.mean_time_ms);
    most.add(score.range_m, score.max_site_time_ms);
    chart.x_ticks.push_back(score.range_m);
  }
  const double margin_m = mean.x.size() > 1 ? 0.6 * (mean.x[1] - mean.x[0]) : 1.0;
  chart.least_x = mean.x.front() - margin_m;
  chart.greatest_x = mean.x.back() + margin_m;
  chart.series = {mean, most};
  return html_figure({"figure-6", "Time by range.",
                      "Mean and longest matching time of each static range: CPU time of one thread "
                      "for cropping, subsampling and matching a scan.",
                      chart_svg(chart), ""});
}

std::string table_two(const Evaluation& evaluation) {
  TextGrid rows = {{"", "mean matching time (ms)", "longest mean time of a site (ms)",
                    "mean range (m)", "mean error (cm)", "sites within the limit (%)"}};
  const auto append = [&](const std::string& title, const RuleScore& score, bool has_limit) {
    rows.push_back({title, fixed(score.mean_time_ms, 2), fixed(score.max_site_time_ms, 2),
                    fixed(score.mean_range_m, 1), in_centimetres(score.mean_error_m),
                    has_limit ? in_percent(score.coverage) : ""});
  };
  append("static range of " + metres(evaluation.statics.back().range_m),
         evaluation.score(0, Rule::kStaticLongest), false);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    append("dynamic range, limit " + limit_text(evaluation.limits_m[limit]),
           evaluation.score(limit, Rule::kOracle), true);
  }
  return html_table(transposed(rows), "Table II. Matching time in the ideal case");
}

std::string figure_seven(const Evaluation& evaluation, const Sites& sites) {
  const Along along(evaluation, sites);
  Chart chart = route_chart("Shortest range that meets each limit, along the route",
                            "observation range (m)", 240.0);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    chart.series.push_back(along.ranges(limit_text(evaluation.limits_m[limit]), limit_colour(limit),
                                        limit, Rule::kOracle));
    chart.series.back().is_dashed = limit == 1;
  }
  return html_figure({"figure-7", "Shortest ranges.",
                      "The shortest range with an error within each limit (ideal case), or the "
                      "longest range where none was within it.",
                      chart_svg(chart), "ideal-range"});
}

std::string figure_eight(const Evaluation& evaluation, const Sites& sites) {
  const Along along(evaluation, sites);
  Chart chart = route_chart("Matching time along the route, static and ideal dynamic ranges",
                            "matching time (ms)");
  chart.series.push_back(along.times("static " + metres(evaluation.statics.back().range_m), kGrey,
                                     0, Rule::kStaticLongest));
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    chart.series.push_back(along.times("dynamic, " + limit_text(evaluation.limits_m[limit]),
                                       limit_colour(limit), limit, Rule::kOracle));
  }
  return html_figure({"figure-8", "Their time.",
                      "Matching time along the route with the longest static range and with the "
                      "ideal dynamic ranges.",
                      chart_svg(chart), "ideal-time"});
}

}  // namespace

// What the paper's section II shows: error and matching time for every static range.
Section ranges_section(const Evaluation& evaluation, const Sites& sites) {
  const bool is_known = evaluation.reference == ErrorReference::kKnownPose;
  const bool is_simulated = evaluation.reference == ErrorReference::kSimulated;
  Section section = {"ranges", "Error and matching time by range", ""};
  section.html = paragraph(
      concat("Drive ", evaluation.drive, " was matched against the map at ",
             evaluation.sites.size(), " of ", evaluation.site_count,
             " sites and at every range, from several starts around the reference pose. The error "
             "is the distance to ",
             (is_known       ? "the known pose."
              : is_simulated ? "the pose of the simulated scan: no drive was recorded here."
                             : "the match at the sensor's full range.")));
  section.html += table_one(evaluation) + figure_five(evaluation, sites) + figure_six(evaluation);
  return section;
}

// What the paper's section III shows: the range that is enough, were the error known beforehand.
Section ideal_section(const Evaluation& evaluation, const Sites& sites) {
  Section section = {"ideal", "Ideal case: ranges chosen with known errors", ""};
  section.html =
      paragraph(
          "A bound for every method: each site takes the shortest range whose error was within the "
          "limit on this drive. No map can predict it exactly; it shows how much can be gained.") +
      table_two(evaluation) + figure_seven(evaluation, sites) + figure_eight(evaluation, sites);
  return section;
}

}  // namespace sightline
