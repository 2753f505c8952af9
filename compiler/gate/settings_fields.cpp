#include "compiler/gate/settings_fields.h"

namespace sightline {

GateOptions options_of(const GateSettings& settings) {
  return {settings.stretch_m, settings.change_stretch_m,
          std::string(severity_name(settings.fails_at))};
}

std::vector<OptionField> option_fields(GateOptions& options) {
  return {
      number("stretch_m", options.stretch_m, "route that is judged at a time, m", 0.1, 1e6),
      number("change_stretch_m", options.change_stretch_m,
             "route whose change is judged at a time, m", 0.1, 1e6),
      choice("fails_at", options.fails_at, "the least severity of a finding that fails the gate",
             {"error", "warning", "note"})};
}

std::vector<OptionField> option_fields(RuleOptions& options) {
  return {choice("severity", options.severity, "of what breaks it; off: it is not judged",
                 {"error", "warning", "note", "off"}),
          number("allowed", options.allowed, "the threshold, in the rule's unit", -1e12, 1e12)};
}

std::vector<OptionField> option_fields(ExceptionOptions& options) {
  return {text("rule", options.rule, "id of the rule that it excepts from; *: every rule"),
          number("limit_m", options.limit_m, "the limit that it covers; without: every limit",
                 0.001, 1000.0),
          text("reason", options.reason, "why; reports repeat it"),
          text("until", options.until, "the last day that it covers, YYYY-MM-DD")};
}

std::vector<OptionField> option_fields(RouteOptions& options) {
  return {integer("run", options.run, "of the route, from 0", 0, 2'000'000'000),
          number("from_m", options.from_s_m, "way along the run where it begins, m", -1e9, 1e9),
          number("to_m", options.to_s_m, "where it ends, m", -1e9, 1e9)};
}

}  // namespace sightline
