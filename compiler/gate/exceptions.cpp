#include "compiler/gate/exceptions.h"

#include <algorithm>

namespace sightline {
namespace {

bool covers(const GateException& exception, const Sites& sites, std::size_t index) {
  const Site& site = sites.sites[index];
  const Eigen::Vector2d p_world_m = (site.p_map_m + sites.frame.origin_world_m).head<2>();
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

std::string in_words(const GateException& exception) {
  return "the exception of " + exception.rule + " until " + exception.until + " (" +
         exception.reason + ")";
}

}  // namespace

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
          in_words(exception) + " ended " + std::to_string(late_days) + " days ago");
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
      check.exception = exception.reason + " (until " + exception.until + ")";
    }
    if (!is_used) add("exception-unused", 1.0, in_words(exception) + " covers no finding");
  }
  report.checks.insert(report.checks.end(), own.begin(), own.end());
}

}  // namespace sightline
