#include "compiler/gate/gate.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/gate/exceptions.h"
#include "compiler/gate/rules/rules.h"

namespace sightline {
namespace {

GateMapCard card_of(const GateMap& map) {
  return {map.file, map.map.map_id, map.map.version, map.map.release,
          to_hex(map.summary.root_digest)};
}

Result<void> check_subject(const GateSubject& subject, const std::string& today) {
  if (!is_date(today)) {
    return Error{ErrorCode::kBadArgument,
                 "today: found '" + today + "', expected a day as YYYY-MM-DD"};
  }
  if (subject.observation == nullptr) return {};
  const CompiledMap& map = subject.map.map;
  const bool fits =
      subject.observation->site_count == map.ranges.site_count &&
      std::ranges::equal(subject.observation->limits, map.ranges.promises, {},
                         &ObservedLimit::limit_m, &LimitPromise::limit_m) &&
      std::ranges::all_of(subject.observation->limits, [&](const ObservedLimit& limit) {
        return limit.worst_begin_site < map.ranges.site_count;
      });
  if (fits) return {};
  return Error{ErrorCode::kMismatchedInputs,
               fmt::format("the evaluation is of a map with {} sites and {} limits, this one has "
                           "{} and {}, or its limits are others: evaluate this map",
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

bool can_be_asked(const GateRule& rule, const GateInput& input) {
  switch (rule.needs) {
    case Needs::kMap:
      return true;
    case Needs::kObservation:
      return input.observation != nullptr;
    case Needs::kOldMap:
      return input.old_map != nullptr;
    case Needs::kExceptions:
      return false;
  }
  SIGHTLINE_CHECK(false);
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
  for (const GateRule& rule : gate_rules()) {
    const RuleSetting& setting = settings.rules.at(std::string(rule.id));
    if (!setting.is_on || !can_be_asked(rule, input)) continue;
    for (Found& found : rule.find(input, setting.threshold)) {
      report.checks.push_back(check_of(rule, setting, std::move(found)));
    }
  }
  apply_exceptions(settings, *input.map, input.old_map, report);
  return report;
}

}  // namespace sightline
