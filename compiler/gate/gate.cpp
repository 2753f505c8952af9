#include "compiler/gate/gate.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <vector>

#include "compiler/gate/rules/rules.h"
#include "compiler/gate/settings.h"
#include "formats/map/compiled_map.h"

namespace sightline {
namespace {

bool covers(const GateException& exception, const Sites& sites, std::size_t index) {
  const Site& site = sites.sites[index];
  const Eigen::Vector2d p_world_m = sites.frame.world_m(site.p_map_m).head<2>();
  if (const auto* circle = std::get_if<CirclePlace>(&exception.place)) {
    return (p_world_m - circle->centre_world_m).norm() <= circle->radius_m;
  }
  if (const auto* box = std::get_if<BoxPlace>(&exception.place)) {
    return (p_world_m.array() >= box->least_world_m.array()).all() &&
           (p_world_m.array() <= box->greatest_world_m.array()).all();
  }
  if (const auto* route = std::get_if<RoutePlace>(&exception.place)) {
    return site.run == route->run && site.s_m >= route->from_s_m && site.s_m <= route->to_s_m;
  }
  return true;
}

bool covers(const GateException& exception, const Sites& sites, const Check& check) {
  if (exception.rule != "*" && exception.rule != check.rule) return false;
  if (exception.limit_m && exception.limit_m != check.limit_m) return false;
  if (!check.place) return std::holds_alternative<WholeMap>(exception.place);
  for (std::size_t site = check.place->first_site; site <= check.place->last_site; ++site) {
    if (!covers(exception, sites, site)) return false;
  }
  return true;
}

Check of_exception(const GateSettings& settings, const std::string& rule, double found,
                   std::string message) {
  const RuleSetting& setting = settings.rules.at(rule);
  Check check;
  check.rule = rule;
  check.severity = setting.severity;
  check.verdict = Verdict::kViolated;
  check.found = found;
  check.allowed = 0.0;
  check.unit = rule == "exception-expired" ? "days" : "exceptions";
  check.message = std::move(message);
  return check;
}

std::string named(const GateException& exception) {
  return concat("the exception of ", exception.rule, " until ", exception.until, " (",
                exception.reason, ")");
}

// Turns violations that a valid exception covers into excepted checks, and appends the findings
// about the exceptions themselves. `old_map` may be nullptr.
void apply_exceptions(const GateSettings& settings, const CompiledMap& map,
                      const CompiledMap* old_map, GateReport& report) {
  std::vector<Check> own;
  const auto add = [&](const std::string& rule, double found, std::string message) {
    if (settings.rules.at(rule).is_on) {
      own.push_back(of_exception(settings, rule, found, std::move(message)));
    }
  };
  for (const GateException& exception : settings.exceptions) {
    const int late_days = days_between(exception.until, report.today);
    if (late_days > 0) {
      add("exception-expired", late_days,
          concat(named(exception), " ended ", late_days, " days ago"));
      continue;
    }
    bool is_used = false;
    for (Check& check : report.checks) {
      const bool is_of_old = check.place && check.place->is_of_old;
      const Sites& sites = is_of_old && old_map != nullptr ? old_map->sites : map.sites;
      const bool is_open =
          check.verdict == Verdict::kViolated || check.verdict == Verdict::kExcepted;
      if (!is_open || !covers(exception, sites, check)) continue;
      is_used = true;
      if (check.verdict == Verdict::kExcepted) continue;  // the first exception is named
      check.verdict = Verdict::kExcepted;
      check.exception = concat(exception.reason, " (until ", exception.until, ")");
    }
    if (!is_used) add("exception-unused", 1.0, named(exception) + " covers no finding");
  }
  report.checks.insert(report.checks.end(), own.begin(), own.end());
}

GateMapCard card_of(const GateMap& map) {
  return {map.file, map.map.map_id, map.map.version, map.map.release,
          to_hex(map.summary.root_digest)};
}

Result<void> check_subject(const GateSubject& subject, const std::string& today) {
  if (!is_date(today)) {
    return Error{ErrorCode::kBadArgument,
                 concat("today: found '", today, "', expected a day as YYYY-MM-DD")};
  }
  if (subject.observation == nullptr) return {};
  const std::string& judged = subject.observation->root_digest;
  const std::string root_digest = to_hex(subject.map.summary.root_digest);
  if (!judged.empty() && judged != root_digest) {
    return Error{ErrorCode::kMismatchedInputs,
                 fmt::format("the evaluation is of the map with the root digest {}, this map has "
                             "{}. Evaluate this map: `sightline evaluate CONFIG --map MAP --json "
                             "FILE`",
                             judged, root_digest)};
  }
  const CompiledMap& map = subject.map.map;
  const bool fits =
      subject.observation->site_count == map.ranges.site_count &&
      std::ranges::equal(subject.observation->limits, map.ranges.promises, {},
                         &ObservedLimit::limit_m, &LimitPromise::limit_m) &&
      std::ranges::all_of(subject.observation->limits, [&](const ObservedLimit& limit) {
        return limit.worst_begin_site < map.ranges.site_count;
      });
  if (fits) return {};
  return Error{
      ErrorCode::kMismatchedInputs,
      fmt::format("the evaluation is of a map with {} sites and {} limits, this map has {} "
                  "and {}, or its limits differ. Evaluate this map: `sightline evaluate "
                  "CONFIG --map MAP --json FILE`",
                  subject.observation->site_count, subject.observation->limits.size(),
                  map.ranges.site_count, map.ranges.promises.size())};
}

GateInput input_of(const GateSubject& subject, const GateSettings& settings) {
  GateInput input;
  input.map = &subject.map.map;
  input.format = subject.map.summary.format;
  input.observation = subject.observation;
  input.stretch_m = settings.stretch_m;
  input.change_stretch_m = settings.change_stretch_m;
  if (subject.old_map == nullptr) return input;
  input.old_map = &subject.old_map->map;
  input.old_format = subject.old_map->summary.format;
  input.pairs = pair_sites(*input.map, *input.old_map);
  return input;
}

bool can_judge(const GateRule& rule, const GateInput& input) {
  if (rule.needs == Needs::kObservation) return input.observation != nullptr;
  if (rule.needs == Needs::kOldMap) return input.old_map != nullptr;
  return rule.needs == Needs::kMap;
}

// A drive that the map was made from observes nothing.
std::vector<Found> found_by(const GateRule& rule, const GateInput& input,
                            const Threshold& threshold) {
  if (rule.needs != Needs::kObservation || !is_own(input.observation->origin)) {
    return rule.find(input, threshold);
  }
  const bool is_split = input.observation->origin == DriveOrigin::kOtherScans;
  return not_judged(fmt::format(
      "drive {} is not an observation: {}", input.observation->drive,
      is_split ? "same drive, other scans" : "the map, its errors or its model were made from it"));
}

Check check_of(const GateRule& rule, const RuleSetting& setting, Found found) {
  Check check;
  check.rule = rule.id;
  check.severity = setting.severity;
  check.limit_m = found.limit_m;
  check.place = found.place;
  check.found = found.value;
  check.allowed = setting.threshold.at(found.limit_m);
  check.unit = rule.unit;
  check.message = std::move(found.message);
  if (!found.is_known || !check.allowed) {
    check.verdict = Verdict::kNotJudged;
    if (found.is_known) check.message += "; no bound is set";
    return check;
  }
  const bool is_met = is_within(check.found, rule.bound, *check.allowed);
  check.verdict = is_met ? Verdict::kMet : Verdict::kViolated;
  const char* side = rule.bound == Bound::kAtMost ? "at most " : "at least ";
  check.message += "; allowed is " + (side + in_words(*check.allowed, rule.unit));
  return check;
}

}  // namespace

Result<GateReport> judge(const GateSubject& subject, const GateSettings& settings,
                         const std::string& today) {
  SIGHTLINE_TRY(check_subject(subject, today));
  const GateInput input = input_of(subject, settings);
  GateReport report;
  report.map = card_of(subject.map);
  if (subject.old_map != nullptr) report.old_map = card_of(*subject.old_map);
  report.today = today;
  report.fails_at = settings.fails_at;
  report.verdict = judge_map(subject.map.map, subject.evaluation, {.map = subject.map.file});
  for (const GateRule& rule : gate_rules()) {
    const RuleSetting& setting = settings.rules.at(std::string(rule.id));
    if (!setting.is_on || !can_judge(rule, input)) continue;
    for (Found& found : found_by(rule, input, setting.threshold)) {
      report.checks.push_back(check_of(rule, setting, std::move(found)));
    }
  }
  apply_exceptions(settings, *input.map, input.old_map, report);
  return report;
}

}  // namespace sightline
