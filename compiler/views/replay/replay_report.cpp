#include "compiler/views/replay/replay_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/base/statistics.h"
#include "formats/base/units.h"
#include "formats/text/json_text.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostStretches = 5;  // that a person is shown
constexpr double kMsPerNs = 1e-6;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return quantile_of_sorted(values, share);
}

double period_ms(const std::vector<ListedScan>& scans) {
  std::vector<double> steps_ms;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    steps_ms.push_back(static_cast<double>(scans[i].stamp_ns - scans[i - 1].stamp_ns) * kMsPerNs);
  }
  return quantile(std::move(steps_ms), 0.5);
}

bool is_doubtful(const ReplayedScan& scan) {
  return scan.state == ScanState::kLost ||
         (scan.state == ScanState::kLocalized && scan.is_in_doubt);
}

std::vector<DoubtfulStretch> stretches_of(const ReplayedDrive& drive) {
  std::vector<DoubtfulStretch> stretches;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const ReplayedScan& scan = drive.scans[i];
    if (!is_doubtful(scan)) continue;
    const bool is_lost = scan.state == ScanState::kLost;
    const Eigen::Vector3d at_m = scan.T_world_vehicle.translation();
    const bool goes_on = !stretches.empty() && stretches.back().last + 1 == i &&
                         stretches.back().is_lost == is_lost &&
                         stretches.back().has_place == scan.has_pose;
    if (!goes_on) stretches.push_back({is_lost, i, i, at_m, at_m, scan.has_pose});
    stretches.back().last = i;
    stretches.back().last_world_m = at_m;
  }
  return stretches;
}

std::string place_text(const Eigen::Vector3d& at_m) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", at_m.x(), at_m.y(), at_m.z());
}

std::string stretch_text(const DoubtfulStretch& stretch) {
  const std::string what = stretch.is_lost ? "lost at " : "";
  if (!stretch.has_place && stretch.scan_count() == 1) {
    return fmt::format("not found: scan {}", stretch.first);
  }
  if (!stretch.has_place) {
    return fmt::format("not found: scans {} to {}", stretch.first, stretch.last);
  }
  if (stretch.scan_count() == 1) {
    return fmt::format("{}scan {} {}", what, stretch.first, place_text(stretch.first_world_m));
  }
  return fmt::format("{}scans {} to {} {} to {}", what, stretch.first, stretch.last,
                     place_text(stretch.first_world_m), place_text(stretch.last_world_m));
}

// The longest first; lost ones before those in doubt.
std::string stretches_text(std::vector<DoubtfulStretch> stretches) {
  std::ranges::stable_sort(stretches, [](const DoubtfulStretch& a, const DoubtfulStretch& b) {
    return a.is_lost != b.is_lost ? a.is_lost : a.scan_count() > b.scan_count();
  });
  std::string text;
  const std::size_t shown = std::min(stretches.size(), kMostStretches);
  for (std::size_t i = 0; i < shown; ++i) {
    text += (i == 0 ? "" : "; ") + stretch_text(stretches[i]);
  }
  if (shown < stretches.size()) text += fmt::format("; and {} more", stretches.size() - shown);
  return text;
}

std::string share_text(std::size_t count, std::size_t of) {
  return of == 0 ? "0 %" : percent(static_cast<double>(count) / static_cast<double>(of));
}

// "1 scan", "3 scans"
std::string counted(std::size_t count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string lost_text(const ReplayFigures& figures) {
  const std::string skipped =
      figures.skipped_count == 0
          ? ""
          : fmt::format("; {} could not be read", counted(figures.skipped_count, "scan"));
  if (figures.lost_scan_count == 0) return "never" + skipped;
  return fmt::format("{} ({}), {} after it was localized{}",
                     counted(figures.lost_scan_count, "scan"),
                     share_text(figures.lost_scan_count, figures.scan_count),
                     counted(figures.lost_count, "time"), skipped);
}

std::string time_text(const ReplayFigures& figures) {
  std::string text = fmt::format("{:.2f} ms per scan (median), {:.2f} ms (p99)", figures.median_ms,
                                 figures.p99_ms);
  if (figures.period_ms <= 0.0) return text;
  return text + fmt::format(": {} and {} of the {:.0f} ms between scans",
                            percent(figures.median_ms / figures.period_ms),
                            percent(figures.p99_ms / figures.period_ms), figures.period_ms);
}

std::string doubt_text(const ReplayFigures& figures) {
  if (figures.stretches.empty()) return "never";
  const std::string retried =
      figures.second_look_count == 0
          ? ""
          : fmt::format(", {} of these after the plan's second look", figures.second_look_count);
  return fmt::format("{} ({}){}: {}", counted(figures.doubtful_count, "scan"),
                     share_text(figures.doubtful_count, figures.scan_count), retried,
                     stretches_text(figures.stretches));
}

// Of several maps.
std::string maps_text(const std::vector<UsedMap>& maps) {
  if (maps.size() < 2) return "";
  std::string text;
  for (const UsedMap& map : maps) {
    text += fmt::format("{}{} {}", text.empty() ? "Maps       " : "; ", map.file,
                        map.fault ? "cannot be read" : counted(map.localized_count, "scan"));
  }
  return text + "\n";
}

std::string delta_text(const TrajectoryErrorOptions& options) {
  return options.unit == DeltaUnit::kMetres
             ? fmt::format("over {:g} m", options.delta)
             : fmt::format("over {:.0f} frame{}", options.delta, options.delta > 1.0 ? "s" : "");
}

std::vector<std::string> row_of(const std::string& name, const ErrorStatistics& errors) {
  std::vector<std::string> row = {name};
  for (const double value :
       {errors.rmse, errors.mean, errors.median, errors.max, errors.min, errors.std}) {
    row.push_back(fmt::format("{:.6f}", value));
  }
  return row;
}

std::string compared_text(const ComparedPoses& compared) {
  const TrajectoryErrors& errors = compared.errors;
  const std::string relative = "relative, " + delta_text(compared.options);
  TextGrid grid = {{"error", "rmse", "mean", "median", "max", "min", "std"},
                   row_of("absolute, m", errors.absolute_m),
                   row_of("absolute, degrees", errors.absolute_deg)};
  if (errors.relative_m.count > 0) {
    grid.push_back(row_of(relative + ", m", errors.relative_m));
    grid.push_back(row_of(relative + ", degrees", errors.relative_deg));
  }
  return fmt::format("\n{} poses compared with {}{}\n{}", errors.pair_count, compared.file,
                     compared.options.is_aligned ? ", aligned" : ", not aligned", aligned(grid));
}

Json position_json(const Eigen::Vector3d& at_m) { return {at_m.x(), at_m.y(), at_m.z()}; }

Json stretch_json(const DoubtfulStretch& stretch) {
  const auto place = [&](const Eigen::Vector3d& at_m) {
    return stretch.has_place ? position_json(at_m) : Json();
  };
  return {{"state", stretch.is_lost ? "lost" : "in-doubt"},
          {"first_scan", stretch.first},
          {"last_scan", stretch.last},
          {"first_world_m", place(stretch.first_world_m)},
          {"last_world_m", place(stretch.last_world_m)}};
}

Json statistics_json(const ErrorStatistics& errors) {
  if (errors.count == 0) return nullptr;
  return {{"count", errors.count},   {"rmse", errors.rmse}, {"mean", errors.mean},
          {"median", errors.median}, {"std", errors.std},   {"min", errors.min},
          {"max", errors.max}};
}

Json maps_json(const std::vector<UsedMap>& maps) {
  Json json = Json::array();
  for (const UsedMap& map : maps) {
    json.push_back({{"file", map.file},
                    {"localized", map.localized_count},
                    {"fault", map.fault ? Json(to_string(*map.fault)) : Json()}});
  }
  return json;
}

Json compared_json(const ComparedPoses& compared) {
  const TrajectoryErrors& errors = compared.errors;
  return {{"file", compared.file},
          {"pairs", errors.pair_count},
          {"is_aligned", compared.options.is_aligned},
          {"most_apart_s", static_cast<double>(compared.options.most_apart_ns) / kSecond_ns},
          {"delta", compared.options.delta},
          {"delta_unit", compared.options.unit == DeltaUnit::kMetres ? "m" : "f"},
          {"absolute_m", statistics_json(errors.absolute_m)},
          {"absolute_deg", statistics_json(errors.absolute_deg)},
          {"relative_m", statistics_json(errors.relative_m)},
          {"relative_deg", statistics_json(errors.relative_deg)}};
}

}  // namespace

std::vector<UsedMap> maps_of(const JoinedMaps& maps, const ReplayedDrive& drive) {
  std::vector<UsedMap> used;
  for (std::size_t i = 0; i < maps.count(); ++i) {
    used.push_back({maps.file(i), 0, maps.fault(i)});
  }
  for (const ReplayedScan& scan : drive.scans) {
    used[scan.map].localized_count += scan.state == ScanState::kLocalized ? 1 : 0;
  }
  return used;
}

ReplayFigures figures_of(const std::vector<ListedScan>& scans, const ReplayedDrive& drive) {
  ReplayFigures figures;
  figures.scan_count = scans.size();
  figures.lost_count = drive.lost_count;
  std::vector<double> times_ms;
  for (const ReplayedScan& scan : drive.scans) {
    figures.localized_count += scan.state == ScanState::kLocalized ? 1 : 0;
    figures.lost_scan_count += scan.state == ScanState::kLost ? 1 : 0;
    figures.skipped_count += scan.state == ScanState::kSkipped ? 1 : 0;
    const bool is_in_doubt = scan.state == ScanState::kLocalized && scan.is_in_doubt;
    figures.doubtful_count += is_in_doubt ? 1 : 0;
    figures.second_look_count += is_in_doubt && scan.look_count > 1 ? 1 : 0;
    if (scan.state != ScanState::kSkipped) times_ms.push_back(scan.time_ms);
  }
  if (!scans.empty()) {
    figures.duration_s =
        static_cast<double>(scans.back().stamp_ns - scans.front().stamp_ns) / kSecond_ns;
  }
  figures.period_ms = period_ms(scans);
  figures.median_ms = quantile(times_ms, 0.5);
  figures.p99_ms = quantile(times_ms, 0.99);
  figures.stretches = stretches_of(drive);
  return figures;
}

std::string to_text(const ReplayReport& report) {
  const ReplayFigures& figures = report.figures;
  return fmt::format("Localized  {} of {} scans ({}) of {}, {:.1f} s\n", figures.localized_count,
                     figures.scan_count, share_text(figures.localized_count, figures.scan_count),
                     report.drive, figures.duration_s) +
         fmt::format("Lost       {}\nTime       {}\nIn doubt   {}\n", lost_text(figures),
                     time_text(figures), doubt_text(figures)) +
         maps_text(report.maps) + (report.compared ? compared_text(*report.compared) : "");
}

std::string to_json(const ReplayReport& report) {
  const ReplayFigures& figures = report.figures;
  Json stretches = Json::array();
  for (const DoubtfulStretch& stretch : figures.stretches) {
    stretches.push_back(stretch_json(stretch));
  }
  const Json json = {{"format", "sightline-localize"},
                     {"version", 1},
                     {"drive", report.drive},
                     {"map", report.maps.front().file},
                     {"maps", maps_json(report.maps)},
                     {"duration_s", figures.duration_s},
                     {"scans", figures.scan_count},
                     {"localized", figures.localized_count},
                     {"in_doubt", figures.doubtful_count},
                     {"lost", figures.lost_scan_count},
                     {"skipped", figures.skipped_count},
                     {"times_lost", figures.lost_count},
                     {"time",
                      {{"median_ms", figures.median_ms},
                       {"p99_ms", figures.p99_ms},
                       {"period_ms", figures.period_ms}}},
                     {"stretches", stretches},
                     {"compared", report.compared ? compared_json(*report.compared) : Json()}};
  return json_text(json);
}

}  // namespace sightline
