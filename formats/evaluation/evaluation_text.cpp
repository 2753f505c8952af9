#include <algorithm>
#include <cmath>

#include "formats/evaluation/evaluation.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

std::string table_one(const Evaluation& evaluation) {
  TextGrid grid = {{"range (m)"},           {"error (cm)"},         {"time, mean (ms)"},
                   {"max over sites (ms)"}, {"max over runs (ms)"}, {"time / longest"},
                   {"work / longest"},      {"predicted: R^2"}};
  const StaticScore& longest = evaluation.statics.back();
  for (const StaticScore& score : evaluation.statics) {
    const auto ratio = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
    const std::string column[] = {fixed(score.range_m, 0),
                                  in_centimetres(score.mean_error_m),
                                  fixed(score.mean_time_ms, 1),
                                  fixed(score.max_site_time_ms, 1),
                                  fixed(score.max_run_time_ms, 1),
                                  fixed(ratio(score.mean_time_ms, longest.mean_time_ms), 2),
                                  fixed(ratio(score.mean_work, longest.mean_work), 2),
                                  fixed(score.r_squared, 2)};
    for (std::size_t i = 0; i < grid.size(); ++i) grid[i].push_back(column[i]);
  }
  return std::string("Table I. Error and matching time for different ranges\n") + aligned(grid);
}

std::string table_two(const Evaluation& evaluation) {
  TextGrid grid = {{"ideal case"},         {"time, mean (ms)"}, {"max over sites (ms)"},
                   {"max over runs (ms)"}, {"mean range (m)"},  {"error (cm)"}};
  const auto append = [&](const std::string& title, const RuleScore& score) {
    const std::string column[] = {title,
                                  fixed(score.mean_time_ms, 1),
                                  fixed(score.max_site_time_ms, 1),
                                  fixed(score.max_run_time_ms, 1),
                                  fixed(score.mean_range_m, 1),
                                  in_centimetres(score.mean_error_m)};
    for (std::size_t i = 0; i < grid.size(); ++i) grid[i].push_back(column[i]);
  };
  append(concat("static ", fixed(evaluation.statics.back().range_m, 0), " m"),
         evaluation.score(0, Rule::kStaticLongest));
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    append(concat("dynamic ", fixed(100.0 * evaluation.limits_m[limit], 0), " cm"),
           evaluation.score(limit, Rule::kOracle));
  }
  return std::string("Table II. Matching time where the error is known beforehand\n") +
         aligned(grid);
}

const JudgedSite& judged_site(const Evaluation& evaluation, std::uint32_t site) {
  return *std::ranges::lower_bound(evaluation.sites, site, {}, &JudgedSite::site);
}

// "120 to 219, (31, -4) to (88, 12)": sites, and their world coordinates.
std::string worst_place(const Evaluation& evaluation, const MapFrame& frame,
                        const RuleScore& score) {
  const auto place = [&](std::uint32_t site) {
    const JudgedSite& judged = judged_site(evaluation, site);
    const Eigen::Vector3d p_m = frame.world_m({judged.p_x_m, judged.p_y_m, 0.0});
    // Plus 0: no minus before a zero.
    return concat("(", fixed(std::round(p_m.x()) + 0.0, 0), ", ",
                  fixed(std::round(p_m.y()) + 0.0, 0), ")");
  };
  return concat(score.worst_begin_site, " to ", score.worst_end_site, ", ",
                place(score.worst_begin_site), " to ", place(score.worst_end_site));
}

std::string heading(const Evaluation& evaluation, const std::string& what, std::size_t limit) {
  return concat(what, " at a limit of ", fixed(100.0 * evaluation.limits_m[limit], 0), " cm");
}

std::string rules_at(const Evaluation& evaluation, const MapFrame& frame, std::size_t limit) {
  TextGrid grid = {{"rule", "coverage %", "error cm", "p95 cm", "range m", "time ratio",
                    "work ratio", "answered %", "missed of answered %", "unmet %",
                    "of these truly %", "worst stretch %", "its sites, world x, y (m)"}};
  for (std::size_t i = 0; i < kRuleCount; ++i) {
    const RuleScore& score = evaluation.score(limit, static_cast<Rule>(i));
    grid.push_back({std::string(name_of(score.rule)), in_percent(score.coverage),
                    in_centimetres(score.mean_error_m), in_centimetres(score.p95_error_m),
                    fixed(score.mean_range_m, 1), fixed(score.time_ratio, 3),
                    fixed(score.work_ratio, 3), in_percent(1.0 - score.unmet_share),
                    in_percent(score.answered_miss_share), in_percent(score.unmet_share),
                    score.unmet_share > 0.0 ? in_percent(score.truly_unmet_share) : "-",
                    in_percent(score.worst_coverage), worst_place(evaluation, frame, score)});
  }
  return concat(
      heading(evaluation, "Rules", limit),
      " (ratios to the static longest range; unmet: not answered, truly: the longest range misses "
      "too; worst ",
      fixed(evaluation.stretch_m, 0), " m of route)\n", aligned(grid));
}

// "93.1 (12.4 m, 6.0 cm)"
std::string kind_cell(const KindScore& score) {
  return concat(in_percent(score.coverage), " (", fixed(score.mean_range_m, 1), " m, ",
                in_centimetres(score.mean_error_m), " cm)");
}

std::string kinds_at(const Evaluation& evaluation, std::size_t limit) {
  TextGrid grid = {{"rule"}, {"share of sites %"}};
  for (std::size_t i = 0; i < kRuleCount; ++i) {
    grid.push_back({std::string(name_of(static_cast<Rule>(i)))});
  }
  for (const KindScore& score : evaluation.kinds) {
    if (score.limit_m != evaluation.limits_m[limit]) continue;
    if (score.rule == Rule::kMap) {
      grid[0].emplace_back(name_of(score.kind));
      grid[1].push_back(in_percent(score.site_share));
    }
    grid[2 + static_cast<std::size_t>(score.rule)].push_back(kind_cell(score));
  }
  return concat(heading(evaluation, "Coverage % by kind of place (mean range, mean error)", limit),
                "\n", aligned(grid));
}

std::string reliability_at(const Evaluation& evaluation, std::size_t limit) {
  TextGrid grid = {{"promised %"}, {"observed %"}, {"pairs"}};
  for (const ReliabilityBin& bin : evaluation.reliability) {
    if (bin.limit_m != evaluation.limits_m[limit]) continue;
    grid[0].push_back(in_percent(bin.promised));
    grid[1].push_back(in_percent(bin.observed));
    grid[2].push_back(std::to_string(bin.count));
  }
  return concat(
      heading(evaluation, "Calibration: P(error <= limit) over pairs of site and range", limit),
      "\n", aligned(grid));
}

}  // namespace

std::string to_text(const Evaluation& evaluation, const MapFrame& frame) {
  std::string text = concat(
      "Drive ", evaluation.drive, ": ", evaluation.sites.size(), " of ", evaluation.site_count,
      " sites evaluated against ", reference_text(evaluation.reference), "; ",
      evaluation.out_of_fold_count, " of them with cross-validated predictions\n\n");
  text += table_one(evaluation);
  text += "\n";
  text += table_two(evaluation);
  for (std::size_t limit = 0; limit < evaluation.limits_m.size(); ++limit) {
    text += "\n";
    text += rules_at(evaluation, frame, limit);
    if (!evaluation.kinds.empty()) text += "\n" + kinds_at(evaluation, limit);
    text += "\n" + reliability_at(evaluation, limit);
  }
  if (evaluation.samples) text += "\n" + to_text(*evaluation.samples);
  return text;
}

}  // namespace sightline
