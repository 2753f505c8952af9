#include "formats/annotation/drive_tracks.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/record/cells.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

std::vector<double> numbers_of(const DriveTracks& tracks, std::size_t rule,
                               double TrackStep::*number) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < tracks.scans.size(); ++i) {
    numbers.push_back(tracks.step(rule, i).*number);
  }
  return numbers;
}

double ratio_to_longest(const DriveTracks& tracks, std::size_t rule, double TrackStep::*number) {
  const double longest = ordered_sum(numbers_of(tracks, tracks.rules.size() - 1, number));
  return longest > 0.0 ? ordered_sum(numbers_of(tracks, rule, number)) / longest : 0.0;
}

// Whether a rule of that number, or the one before it, stands where it should.
bool is_in_place(const DriveTracks& tracks, std::size_t number) {
  const TrackRule& rule = tracks.rules[number];
  if (rule.is_static() != (rule.limit_m == 0.0)) return false;
  if (!std::isfinite(rule.limit_m) || rule.limit_m < 0.0 || !validate(rule.look)) return false;
  if (number < tracks.limits_m.size()) {
    return rule.choice == TrackChoice::kRange && rule.limit_m == tracks.limits_m[number];
  }
  const TrackRule& before = tracks.rules[number - 1];
  if (rule.choice == TrackChoice::kRange || rule.choice < before.choice) return false;
  return !rule.is_static() || !before.is_static() || !takes_every_return(before.look) ||
         (takes_every_return(rule.look) && rule.look.range_m > before.look.range_m);
}

Result<void> validate_rules(const DriveTracks& tracks) {
  const std::size_t limit_count = tracks.limits_m.size();
  if (limit_count == 0 || tracks.rules.size() <= limit_count || tracks.scans.empty() ||
      tracks.steps.size() != tracks.rules.size() * tracks.scans.size()) {
    return invalid_artifact("a replay needs limits, static ranges and scans, and a step for each",
                            "");
  }
  for (std::size_t i = 0; i < tracks.rules.size(); ++i) {
    if (!is_in_place(tracks, i)) {
      return invalid_artifact("a rule is out of place", concat("rule ", i));
    }
  }
  if (tracks.rules.back().is_static() && takes_every_return(tracks.rules.back().look)) return {};
  return invalid_artifact("the last rule is not a static range, which the others are compared with",
                          "");
}

}  // namespace

bool is_judged_at(const TrackRule& rule, double limit_m) {
  return rule.is_static() || rule.limit_m == limit_m;
}

std::string name_of(const TrackRule& rule) {
  if (rule.choice == TrackChoice::kRange) return "the map's range";
  if (rule.choice == TrackChoice::kLook) return "the map's look";
  return rule.choice == TrackChoice::kPlan ? "the map's plan" : "static " + to_text(rule.look);
}

TrackScore score_track(const DriveTracks& tracks, std::size_t rule, double limit_m) {
  std::vector<double> errors_m = numbers_of(tracks, rule, &TrackStep::error_m);
  std::ranges::sort(errors_m);
  const auto within = std::ranges::upper_bound(errors_m, limit_m) - errors_m.begin();
  TrackScore score;
  score.coverage = static_cast<double>(within) / static_cast<double>(errors_m.size());
  score.mean_error_m = mean_of(errors_m);
  score.p95_error_m = quantile_of_sorted(errors_m, 0.95);
  score.max_error_m = errors_m.back();
  score.mean_range_m = mean_of(numbers_of(tracks, rule, &TrackStep::range_m));
  score.time_ratio = ratio_to_longest(tracks, rule, &TrackStep::time_ms);
  score.work_ratio = ratio_to_longest(tracks, rule, &TrackStep::work);
  score.mean_time_ms = mean_of(numbers_of(tracks, rule, &TrackStep::time_ms));
  for (std::size_t i = 0; i < tracks.scans.size(); ++i) {
    const std::uint8_t flags = tracks.step(rule, i).flags;
    score.track_count += (flags & kTrackBegins) != 0 ? 1 : 0;
    score.lost_count += (flags & kTrackLost) != 0 ? 1 : 0;
    score.second_share += (flags & kTrackSecondLook) != 0 ? 1.0 : 0.0;
  }
  score.second_share /= static_cast<double>(tracks.scans.size());
  return score;
}

Result<void> validate(const DriveTracks& tracks) {
  const bool is_known = tracks.reference == ErrorReference::kKnownPose ||
                        tracks.reference == ErrorReference::kFullRangeMatch;
  if (!is_known || !(tracks.lost_beyond_m > 0.0) || !std::isfinite(tracks.lost_beyond_m)) {
    return invalid_artifact(
        "the reference is unknown, or the distance at which a track is lost is missing", "");
  }
  SIGHTLINE_TRY(validate_rules(tracks));
  for (std::size_t i = 0; i < tracks.steps.size(); ++i) {
    const TrackStep& step = tracks.steps[i];
    const double numbers[] = {step.range_m, step.error_m, step.time_ms, step.work};
    const bool are_usable = std::ranges::all_of(
        numbers, [](double number) { return std::isfinite(number) && number >= 0.0; });
    if (!are_usable || step.flags > (kTrackBegins | kTrackLost | kTrackSecondLook)) {
      return invalid_artifact(
          "a step has a number that is negative or not finite, or an unknown flag",
          concat("step ", i));
    }
  }
  for (const TrackedScan& scan : tracks.scans) {
    if (!std::isfinite(scan.p_x_map_m + scan.p_y_map_m)) {
      return invalid_artifact("the place of a scan is not finite",
                              concat("scan ", scan.recording_index));
    }
  }
  return {};
}

Table dump(const DriveTracks& tracks) {
  Table table;
  table.name = "continuous-localization";
  table.facts = {{"drive", tracks.drive},
                 {"reference", cell_of(tracks.reference)},
                 {"scan_count", static_cast<std::int64_t>(tracks.scans.size())},
                 {"lost_beyond_m", tracks.lost_beyond_m}};
  table.columns = {"rule", "limit_m", "static_range_m", "look"};
  append_columns<TrackScore>(table.columns);
  for (const double limit_m : tracks.limits_m) {
    for (std::size_t i = 0; i < tracks.rules.size(); ++i) {
      const TrackRule& rule = tracks.rules[i];
      if (!is_judged_at(rule, limit_m)) continue;
      table.rows.push_back({cell_of(rule.choice), limit_m, rule.static_range_m(),
                            rule.is_static() ? to_text(rule.look) : ""});
      append_cells(score_track(tracks, i, limit_m), table.rows.back());
    }
  }
  return table;
}

std::vector<Table> tables(const DriveTracks& tracks) {
  Table scans{"continuous-localization-scans",
              {"recording_index", "p_x_m", "p_y_m", "rule", "limit_m", "look", "range_m", "error_m",
               "time_ms", "work", "begins", "is_lost", "has_second_look"},
              {},
              {}};
  for (std::size_t i = 0; i < tracks.scans.size(); ++i) {
    const TrackedScan& scan = tracks.scans[i];
    for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
      const TrackStep& step = tracks.step(rule, i);
      const TrackRule& of = tracks.rules[rule];
      const auto flag = [&](std::uint8_t bit) {
        return std::int64_t{(step.flags & bit) != 0 ? 1 : 0};
      };
      scans.rows.push_back({std::int64_t{scan.recording_index}, scan.p_x_map_m, scan.p_y_map_m,
                            cell_of(of.choice), of.limit_m, of.is_static() ? to_text(of.look) : "",
                            step.range_m, step.error_m, step.time_ms, step.work, flag(kTrackBegins),
                            flag(kTrackLost), flag(kTrackSecondLook)});
    }
  }
  return {dump(tracks), scans};
}

std::string to_text(const DriveTracks& tracks) {
  std::string text = concat(
      "Continuous localization: ", tracks.scans.size(),
      " scans, each matched from the pose that the scans before it predict; a track is lost above ",
      fixed(tracks.lost_beyond_m, 1), " m\n");
  for (const double limit_m : tracks.limits_m) {
    TextGrid grid = {{concat("at ", fixed(100.0 * limit_m, 0), " cm"), "coverage %", "error cm",
                      "p95 cm", "max cm", "range m", "time ratio", "work ratio", "lost",
                      "second look %"}};
    for (std::size_t i = 0; i < tracks.rules.size(); ++i) {
      const TrackRule& rule = tracks.rules[i];
      if (!is_judged_at(rule, limit_m)) continue;
      const TrackScore score = score_track(tracks, i, limit_m);
      grid.push_back(
          {name_of(rule), fixed(100.0 * score.coverage, 1), fixed(100.0 * score.mean_error_m, 1),
           fixed(100.0 * score.p95_error_m, 1), fixed(100.0 * score.max_error_m, 1),
           fixed(score.mean_range_m, 1), fixed(score.time_ratio, 3), fixed(score.work_ratio, 3),
           std::to_string(score.lost_count),
           rule.choice == TrackChoice::kPlan ? fixed(100.0 * score.second_share, 1) : ""});
    }
    text += aligned(grid);
  }
  return text;
}

}  // namespace sightline
