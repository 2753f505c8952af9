#include "compiler/views/picture/charts/calibration_chart.h"
#include "compiler/views/picture/charts/chart.h"
#include "compiler/views/report/sections/sections.h"
#include "compiler/views/text/weakness_text.h"
#include "compiler/views/verdict/verdict.h"
#include "compiler/views/verdict/verdict_sentences.h"

// Promises, how well they match the judging drive, and how well held-out places are predicted.

namespace sightline {
namespace {

std::string promise_text(const LimitPromise& promise) {
  if (!promise.is_earned) return "no promise";
  return "at least " + percent(1.0 - promise.alpha) + " of the answered sites of the next drive";
}

std::string promises_table(const CompiledMap& map) {
  TextGrid grid = {{"limit", "sites within the limit", "required probability", "calibration blocks",
                    "places", "drives", "expected coverage (%)", "mean range (m)", "unmet (%)",
                    "unlike the training data (%)"}};
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
  return html_table(
      grid,
      "Promises of the map. Unmet: no range has the required probability; such sites are "
      "not answered, and no promise is about them");
}

std::string calibration(const Evaluation& evaluation) {
  const Chart chart = calibration_chart(evaluation, {kGrey, {kBlue, kOrange, kGreen}});
  return html_figure({"calibration", "Calibration.",
                      "All pairs of judged site and range, grouped by the predicted probability in "
                      "steps of 10 %. On the dashed line the predictions are right; below it they "
                      "are too optimistic. A larger point has more pairs.",
                      chart_svg(chart), ""});
}

std::string calibration_table(const Evaluation& evaluation) {
  TextGrid grid = {{"limit", "predicted (%)", "observed (%)", "pairs of site and range"}};
  for (const ReliabilityBin& bin : evaluation.reliability) {
    grid.push_back({limit_text(bin.limit_m), in_percent(bin.promised), in_percent(bin.observed),
                    std::to_string(bin.count)});
  }
  return concat("<details><summary>Calibration curve as a table</summary>\n",
                html_table(grid, "Predicted and observed share within the limit, in steps of 10 %"),
                "</details>\n");
}

std::string prediction_table(const Evaluation& evaluation) {
  TextGrid rows = {{"range (m)", "R²", "RMSE (cm)"}};
  for (const StaticScore& score : evaluation.statics) {
    rows.push_back(
        {fixed(score.range_m, 0), fixed(score.r_squared, 2), in_centimetres(score.rmse_m)});
  }
  return html_table(transposed(rows),
                    "Predicted and measured mean error on this drive. R²: 1 is exact, 0 or less is "
                    "not better than a constant");
}

std::string scores_table(const DriveTracks& tracks, double limit_m) {
  TextGrid grid = {{"rule", "scans within the limit (%)", "mean error (cm)", "95th percentile (cm)",
                    "largest (cm)", "mean range (m)", "time ratio", "work ratio", "tracks lost",
                    "scans with a second look (%)"}};
  for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
    const TrackRule& each = tracks.rules[rule];
    if (!is_judged_at(each, limit_m)) continue;
    const TrackScore score = score_track(tracks, rule, limit_m);
    grid.push_back({name_of(each), in_percent(score.coverage), in_centimetres(score.mean_error_m),
                    in_centimetres(score.p95_error_m), in_centimetres(score.max_error_m),
                    fixed(score.mean_range_m, 1), fixed(score.time_ratio, 3),
                    fixed(score.work_ratio, 3), std::to_string(score.lost_count),
                    each.choice == TrackChoice::kPlan ? in_percent(score.second_share) : ""});
  }
  return html_table(grid, concat("Continuous localization at a limit of ", limit_text(limit_m),
                                 ". Ratios: time and work relative to the longest static range"));
}

ChartSeries error_of(const DriveTracks& tracks, std::size_t rule, const std::string& colour) {
  const TrackRule& of = tracks.rules[rule];
  const std::string name = name_of(of) + (of.is_static() ? "" : ", " + limit_text(of.limit_m));
  ChartSeries series = {name, colour, Mark::kLine, 1.4};
  for (std::size_t scan = 0; scan < tracks.scans.size(); ++scan) {
    series.add(static_cast<double>(scan), 100.0 * tracks.step(rule, scan).error_m);
  }
  return series;
}

std::string error_figure(const DriveTracks& tracks) {
  Chart chart = {"Error of continuous localization, scan by scan", "scan number",
                 "localization error (cm)", 1080.0, 260.0};
  chart.least_y = 0.0;
  chart.series.push_back(error_of(tracks, tracks.rules.size() - 1, kGrey));
  for (std::size_t rule = 0; rule < tracks.limits_m.size(); ++rule) {
    chart.series.push_back(error_of(tracks, rule, limit_colour(rule)));
  }
  for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
    const bool is_plan = tracks.rules[rule].choice == TrackChoice::kPlan &&
                         tracks.rules[rule].limit_m == tracks.limits_m.front();
    if (is_plan) chart.series.push_back(error_of(tracks, rule, kPink));
  }
  return html_figure({"tracks", "Continuous localization.",
                      "Error of each scan when every match starts at the pose predicted from the "
                      "matches before: with the ranges of this map, with its plan of looks if it "
                      "has one, and with the longest range everywhere.",
                      chart_svg(chart), ""});
}

std::string advice_text(const ExplainedStretch& one, const Sites& sites) {
  if (one.advice.empty()) return "no place found";
  const TargetAdvice& best = one.advice.front();
  const Eigen::Vector3d p_m = sites.frame.world_m(best.target.foot_map_m);
  return concat("at (", fixed(p_m.x(), 1), ", ", fixed(p_m.y(), 1), "), facing ",
                fixed(facing_deg(best.target), 0), " degrees: ", percent(best.gain), " less");
}

std::string stretches_table(const Weakness& weakness, const Sites& sites) {
  TextGrid grid = {{"worst site", "run", "from (m)", "to (m)", "error (cm)",
                    "margin to the limit (%)", "kind of place", "least constrained direction",
                    "cause", "best place for a board"}};
  for (const ExplainedStretch& one : weakness.stretches) {
    const WeakStretch& stretch = one.stretch;
    grid.push_back({std::to_string(stretch.worst_site), std::to_string(stretch.run),
                    fixed(stretch.from_m, 0), fixed(stretch.to_m, 0),
                    in_centimetres(stretch.worst.error_m), in_percent(stretch.worst.margin),
                    std::string(name_of(one.kind)),
                    std::string(name_of_way(one.loose.off_road_deg)),
                    std::string(name_of(one.cause)), advice_text(one, sites)});
  }
  return html_table(grid, "The weakest stretches; positions are world coordinates, m");
}

// Statements about ranges and looks, but for the sentence below the verdict.
std::string statements_beside(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  const std::string promise = judge_map(map, sources.figures, {}).promise;
  std::string html;
  const auto append = [&](const std::string& kind, const RangeTable& table) {
    for (const LimitPromise& of : table.promises) {
      if (of.statement.empty() || as_sentence(of.statement) == promise) continue;
      html += paragraph(concat(kind, ", ", limit_text(of.limit_m), ": ", of.statement));
    }
  };
  append("Ranges", map.ranges);
  if (map.looks) append("Looks", map.looks->ranges);
  return html;
}

}  // namespace

Section trust_section(const ReportSources& sources) {
  Section section = {"trust", "Promises and calibration", ""};
  section.html = promises_table(*sources.map) + statements_beside(sources);
  if (sources.evaluation) {
    section.html += calibration(*sources.evaluation) + calibration_table(*sources.evaluation) +
                    prediction_table(*sources.evaluation);
  }
  return section;
}

// The judging drive, localized scan by scan.
Section tracks_section(const DriveTracks& tracks) {
  Section section = {"driving", "Continuous localization", ""};
  section.html = paragraph(concat("Drive ", tracks.drive, ", ", tracks.scans.size(),
                                  " scans, localized one after another as in a vehicle. A track is "
                                  "lost where the error exceeds ",
                                  metres(tracks.lost_beyond_m),
                                  "; a new track then begins near the reference pose."));
  for (const double limit_m : tracks.limits_m) section.html += scores_table(tracks, limit_m);
  section.html += error_figure(tracks);
  return section;
}

// Where the map is weak, which way, why, and what would help.
Section weak_section(const Weakness& weakness, const Sites& sites) {
  std::string html = paragraph(summary_sentence(weakness));
  if (weakness.stretches.empty()) return {"weak", "Weak stretches", html};
  html += stretches_table(weakness, sites);
  for (const ExplainedStretch& one : weakness.stretches) {
    html += paragraph(concat("Site ", one.stretch.worst_site, ": ", cause_sentence(one)));
  }
  return {"weak", "Weak stretches", html};
}

}  // namespace sightline
