#include <algorithm>
#include <array>
#include <cmath>

#include "compiler/views/report/sections/along.h"
#include "compiler/views/report/sections/sections.h"

// Section V of the paper: the ranges of the map and their results.

namespace sightline {
namespace {

std::string words_of(Rule rule) {
  static constexpr std::array<const char*, kRuleCount> kWords = {
      "this map",
      "mean rule (the paper's)",
      "probability rule",
      "shortest static range of equal coverage",
      "longest static range",
      "oracle (ideal case)"};
  return kWords[static_cast<std::size_t>(rule)];
}

std::string rules_table(const Evaluation& evaluation, std::size_t limit) {
  TextGrid grid = {{"rule", "coverage (%)", "mean error (cm)", "95th percentile (cm)",
                    "mean range (m)", "time ratio", "work ratio", "unmet (%)",
                    "coverage of the worst stretch (%)", "sites of the worst stretch"}};
  for (std::size_t i = 0; i < kRuleCount; ++i) {
    const RuleScore& score = evaluation.score(limit, static_cast<Rule>(i));
    grid.push_back({words_of(score.rule), in_percent(score.coverage),
                    in_centimetres(score.mean_error_m), in_centimetres(score.p95_error_m),
                    fixed(score.mean_range_m, 1), fixed(score.time_ratio, 3),
                    fixed(score.work_ratio, 3), in_percent(score.unmet_share),
                    in_percent(score.worst_coverage),
                    concat(score.worst_begin_site, " to ", score.worst_end_site)});
  }
  return html_table(
      grid,
      concat("Rules at a limit of ", limit_text(evaluation.limits_m[limit]),
             ". Ratios: time and work relative to the longest static range; the worst stretch is ",
             metres(evaluation.stretch_m), " long"));
}

// "93.1 (12.4 m)"
std::string kinds_table(const Evaluation& evaluation, std::size_t limit) {
  if (evaluation.kinds.empty()) return "";
  TextGrid grid = {{"rule"}, {"share of sites (%)"}};
  for (std::size_t i = 0; i < kRuleCount; ++i) grid.push_back({words_of(static_cast<Rule>(i))});
  for (const KindScore& score : evaluation.kinds) {
    if (score.limit_m != evaluation.limits_m[limit]) continue;
    if (score.rule == Rule::kMap) {
      grid[0].emplace_back(name_of(score.kind));
      grid[1].push_back(in_percent(score.site_share));
    }
    grid[2 + static_cast<std::size_t>(score.rule)].push_back(
        concat(in_percent(score.coverage), " (", fixed(score.mean_range_m, 1), " m)"));
  }
  return html_table(grid, "Coverage (%) and mean range by kind of place");
}

std::string figure_ten(const Evaluation& evaluation, const Sites& sites, std::size_t limit) {
  const Along along(evaluation, sites);
  const std::string limit_words = limit_text(evaluation.limits_m[limit]);
  Chart time =
      route_chart("Matching time: static and this map's ranges", "matching time (ms)", 230.0);
  time.series = {along.times("static " + metres(evaluation.statics.back().range_m), kGrey, limit,
                             Rule::kStaticLongest),
                 along.times("this map, " + limit_words, kBlue, limit, Rule::kMap)};
  Chart range = route_chart("Selected ranges, and places where the error exceeded the limit",
                            "selected range (m)", 230.0);
  range.series = {along.ranges("selected range", kBlue, limit, Rule::kMap)};
  range.bands = along.misses(limit);
  range.band_name = "error above " + limit_words;
  const std::string number = std::to_string(limit);
  return html_figure({"figure-10-" + number, concat("Ranges of the map, limit ", limit_words, "."),
                      "Above: matching time with the longest static range and with the ranges of "
                      "this map. Below: the ranges of this map; bars mark places where the error "
                      "at the selected range exceeded the limit on this drive.",
                      chart_svg(time) + chart_svg(range), "choice-" + number});
}

double coverage_of_range(const Evaluation& evaluation, std::size_t limit, std::size_t range) {
  double met = 0.0;
  for (std::size_t i = range; i < evaluation.error_m.size(); i += evaluation.statics.size()) {
    met += evaluation.error_m[i] <= evaluation.limits_m[limit] ? 1.0 : 0.0;
  }
  return met / static_cast<double>(evaluation.sites.size());
}

ChartSeries static_ranges(const Evaluation& evaluation, std::size_t limit) {
  ChartSeries series = {"static ranges", kGrey, Mark::kPoints, 3.5};
  const double longest_ms = evaluation.statics.back().mean_time_ms;
  for (std::size_t range = 0; range < evaluation.statics.size(); ++range) {
    const double time_ms = evaluation.statics[range].mean_time_ms;
    series.add(longest_ms > 0.0 ? time_ms / longest_ms : 0.0,
               100.0 * coverage_of_range(evaluation, limit, range));
    series.labels.push_back(metres(evaluation.statics[range].range_m));
  }
  return series;
}

// Coverage against time: farther up and to the left is better.
std::string pareto(const Evaluation& evaluation, std::size_t limit) {
  const std::string limit_words = limit_text(evaluation.limits_m[limit]);
  Chart chart = {"Coverage against matching time at " + limit_words,
                 "mean matching time relative to the longest static range",
                 concat("sites within ", limit_words, " (%)"), 640.0, 360.0};
  const ChartSeries points = static_ranges(evaluation, limit);
  chart.series = {{"", kGrey, Mark::kLine, 1.2, true, points.x, points.y}, points};
  const auto add_point = [&](Rule rule, const std::string& colour, double size_px) {
    const RuleScore& score = evaluation.score(limit, rule);
    ChartSeries point = {words_of(rule), colour, Mark::kPoints, size_px};
    point.add(score.time_ratio, 100.0 * score.coverage);
    chart.series.push_back(std::move(point));
  };
  // Drawn smaller the later, so that rules that agree are all seen.
  add_point(Rule::kMap, kBlue, 9.0);
  add_point(Rule::kProbability, kPink, 5.5);
  add_point(Rule::kMean, kOrange, 6.0);
  add_point(Rule::kOracle, kGreen, 6.0);
  chart.greatest_y = 100.0;
  // Room for the label of the lowest point.
  const double lowest = *std::ranges::min_element(points.y) - 8.0;
  chart.least_y = std::max(0.0, 20.0 * std::floor(lowest / 20.0));
  chart.least_x = 0.0;
  chart.greatest_x = 1.1;
  return html_figure({concat("pareto-", limit), concat("Coverage against time, ", limit_words, "."),
                      "Grey points are static ranges. A rule above the dashed line has more sites "
                      "within the limit in the same time; farther up and to the left is better.",
                      chart_svg(chart), ""});
}

}  // namespace

Section choice_section(const Evaluation& evaluation, const Sites& sites) {
  Section section = {"choice", "Ranges of this map on the judging drive", ""};
  section.html =
      paragraph(concat(evaluation.out_of_fold_count, " of the ", evaluation.sites.size(),
                       " judged sites were predicted by a model that was not trained on their "
                       "place. Coverage is the share of judged sites whose error at the selected "
                       "range is within the limit. Read it together with the time: a shorter range "
                       "takes less time, but may miss the limit at more sites."));
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    section.html += concat("<h3>Limit ", limit_text(evaluation.limits_m[limit]), "</h3>\n",
                           rules_table(evaluation, limit), figure_ten(evaluation, sites, limit),
                           pareto(evaluation, limit), kinds_table(evaluation, limit));
  }
  return section;
}

}  // namespace sightline
