#include "compiler/views/picture/charts/chart_svg.h"
#include "compiler/views/report/sections/along.h"
#include "compiler/views/report/sections/sections.h"

// What the paper's section III shows: the range that is enough, were the error known beforehand.

namespace sightline {
namespace {

double chosen_time_ms(const Evaluation& evaluation, std::size_t limit, Rule rule, std::size_t i) {
  return evaluation.time_ms[i * evaluation.statics.size() + evaluation.chosen(limit, rule, i)];
}

std::string colour_of_limit(std::size_t limit) {
  const std::string colours[] = {kBlue, kOrange, kGreen};
  return colours[limit % 3];
}

std::string table_two(const Evaluation& evaluation) {
  TextGrid grid = {{""},
                   {"mean matching time (ms)"},
                   {"greatest of the sites' mean times (ms)"},
                   {"mean range (m)"},
                   {"mean error (cm)"},
                   {"sites within the limit (%)"}};
  const auto append = [&](const std::string& title, const RuleScore& score, bool has_limit) {
    const std::string column[] = {title,
                                  fixed(score.mean_time_ms, 2),
                                  fixed(score.max_site_time_ms, 2),
                                  fixed(score.mean_range_m, 1),
                                  in_centimetres(score.mean_error_m),
                                  has_limit ? in_percent(score.coverage) : ""};
    for (std::size_t i = 0; i < grid.size(); ++i) grid[i].push_back(column[i]);
  };
  append("static range of " + metres(evaluation.statics.back().range_m),
         evaluation.score(0, Rule::kStaticLongest), false);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    append("dynamic range, " + limit_text(evaluation.limits_m[limit]),
           evaluation.score(limit, Rule::kOracle), true);
  }
  return html_table(grid, "Table II. Matching time in the ideal case");
}

std::string figure_seven(const Evaluation& evaluation, const Sites& sites) {
  const Along along(evaluation, sites);
  Chart chart =
      route_chart("Shortest range that meets each limit, along the route", "observation range (m)");
  chart.height_px = 240.0;
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    chart.series.push_back(along.series(
        limit_text(evaluation.limits_m[limit]), colour_of_limit(limit), [&](std::size_t i) {
          return evaluation.statics[evaluation.chosen(limit, Rule::kOracle, i)].range_m;
        }));
    chart.series.back().mark = Mark::kSteps;
    chart.series.back().is_dashed = limit == 1;
  }
  return html_figure(
      {"figure-7", "Figure 7.",
       "The shortest range that truly met each limit (ideal case); the longest where "
       "none did.",
       chart_svg(chart), "ideal-range"});
}

std::string figure_eight(const Evaluation& evaluation, const Sites& sites) {
  const Along along(evaluation, sites);
  Chart chart = route_chart("Matching time along the route, static and ideal dynamic ranges",
                            "matching time (ms)");
  const auto append = [&](const std::string& name, const std::string& colour, std::size_t limit,
                          Rule rule) {
    chart.series.push_back(along.series(
        name, colour, [&](std::size_t i) { return chosen_time_ms(evaluation, limit, rule, i); }));
  };
  append("static " + metres(evaluation.statics.back().range_m), kGrey, 0, Rule::kStaticLongest);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    append("dynamic, " + limit_text(evaluation.limits_m[limit]), colour_of_limit(limit), limit,
           Rule::kOracle);
  }
  return html_figure(
      {"figure-8", "Figure 8.",
       "Matching time at every metre with the static longest range and with the ideal "
       "dynamic ranges.",
       chart_svg(chart), "ideal-time"});
}

}  // namespace

Section ideal_section(const Evaluation& evaluation, const Sites& sites) {
  Section section = {"ideal", "The ideal case: if the error were known beforehand", ""};
  section.html =
      paragraph(
          "A bound for every method: each site takes the shortest range that met the limit on this "
          "very drive. No map can know that; it shows what there is to win.") +
      table_two(evaluation) + figure_seven(evaluation, sites) + figure_eight(evaluation, sites);
  return section;
}

}  // namespace sightline
