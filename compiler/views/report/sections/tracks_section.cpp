#include "compiler/views/picture/charts/chart_svg.h"
#include "compiler/views/report/sections/sections.h"

// The judging drive replayed as a vehicle lives it.

namespace sightline {
namespace {

std::string scores_table(const DriveTracks& tracks, double limit_m) {
  TextGrid grid = {{"rule", "scans within the limit (%)", "mean error (cm)", "95th percentile (cm)",
                    "greatest (cm)", "mean range (m)", "time ratio", "work ratio", "lost",
                    "second look (%)"}};
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
  return html_table(grid, "Continuous localization at a limit of " + limit_text(limit_m) +
                              "; ratios are to the longest static range");
}

ChartSeries error_of(const DriveTracks& tracks, std::size_t rule, const std::string& colour) {
  const TrackRule& of = tracks.rules[rule];
  const std::string name = name_of(of) + (of.is_static() ? "" : ", " + limit_text(of.limit_m));
  ChartSeries series = {name, colour, Mark::kLine, {}, {}, {}, 1.4, false};
  for (std::size_t scan = 0; scan < tracks.scans.size(); ++scan) {
    series.x.push_back(static_cast<double>(scan));
    series.y.push_back(100.0 * tracks.step(rule, scan).error_m);
  }
  return series;
}

std::string error_figure(const DriveTracks& tracks) {
  Chart chart;
  chart.title = "Error of continuous localization, scan by scan";
  chart.x_label = "scan of the drive";
  chart.y_label = "localization error (cm)";
  chart.width_px = 1080.0;
  chart.height_px = 260.0;
  chart.least_y = 0.0;
  chart.series.push_back(error_of(tracks, tracks.rules.size() - 1, kGrey));
  const std::string colours[] = {kBlue, kOrange, kGreen};
  for (std::size_t rule = 0; rule < tracks.limits_m.size(); ++rule) {
    chart.series.push_back(error_of(tracks, rule, colours[rule % 3]));
  }
  for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
    const bool is_plan = tracks.rules[rule].choice == TrackChoice::kPlan &&
                         tracks.rules[rule].limit_m == tracks.limits_m.front();
    if (is_plan) chart.series.push_back(error_of(tracks, rule, kPink));
  }
  return html_figure({"tracks", "Continuous localization.",
                      "Error of every scan when each match starts where the poses found before "
                      "predict, with this map's ranges, by its plan of looks where it has one, and "
                      "with the longest range throughout.",
                      chart_svg(chart), ""});
}

}  // namespace

Section tracks_section(const DriveTracks& tracks) {
  Section section = {"driving", "Driven continuously", ""};
  section.html = paragraph("Drive " + tracks.drive + ", " + std::to_string(tracks.scans.size()) +
                           " scans. A match that ends more than " + metres(tracks.lost_beyond_m) +
                           " off is lost, and the next one begins anew.");
  for (const double limit_m : tracks.limits_m) section.html += scores_table(tracks, limit_m);
  section.html += error_figure(tracks);
  return section;
}

}  // namespace sightline
