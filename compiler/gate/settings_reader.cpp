#include "compiler/gate/settings.h"
#include "compiler/gate/settings_fields.h"
#include "compiler/pipeline/option_yaml.h"

namespace sightline {
namespace {

Error refused(const YamlNode& node, std::string message, ErrorCode code = ErrorCode::kBadValue) {
  return {code, std::move(message), "", node.place()};
}

Result<double> read_number(const YamlNode& node, const std::string& name, double least) {
  double value = 0.0;
  OptionField field = number(name, value, "", least, 1e12);
  SIGHTLINE_TRY(set_field(node, field));
  return value;
}

Result<std::vector<double>> read_numbers(const YamlNode& node, const std::string& what,
                                         std::size_t count) {
  if (node.kind != YamlNode::Kind::kList || node.values.size() != count) {
    return refused(node, what + ": expected a list of " + std::to_string(count) + " numbers");
  }
  std::vector<double> values;
  for (const YamlNode& item : node.values) {
    SIGHTLINE_ASSIGN(const double value, read_number(item, what, -1e12));
    values.push_back(value);
  }
  return values;
}

Severity severity_of(const std::string& name) {
  for (const Severity severity : {Severity::kNote, Severity::kWarning}) {
    if (name == severity_name(severity)) return severity;
  }
  return Severity::kError;
}

Result<void> read_at_limits(const YamlNode& node, Threshold& threshold) {
  if (node.kind != YamlNode::Kind::kMap) {
    return refused(node, "at_limits must be a map of limits");
  }
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    SIGHTLINE_ASSIGN(const double limit_m, read_number(node.keys[i], "a limit of at_limits", 1e-6));
    SIGHTLINE_ASSIGN(const double allowed, read_number(node.values[i], "at_limits", -1e12));
    threshold.at_limits.emplace_back(limit_m, allowed);
  }
  return {};
}

// `rule: 0.9`, `rule: warning`, `rule: off` or `rule: {severity: .., allowed: .., at_limits: ..}`.
Result<void> read_rule(const YamlNode& node, const std::string& id, RuleSetting& setting) {
  if (node.kind == YamlNode::Kind::kNull) return refused(node, "rule '" + id + "' says nothing");
  RuleOptions options{std::string(severity_name(setting.severity)), 0.0};
  std::vector<OptionField> fields = option_fields(options);
  bool says_allowed = node.find("allowed") != nullptr;
  Result<void> set;
  if (node.kind == YamlNode::Kind::kScalar) {
    set = set_field(node, fields[1]);
    says_allowed = set.has_value();
    if (!set) set = set_field(node, fields[0]);
  } else {
    set = set_fields(node, "rule '" + id + "'", fields, {"at_limits"});
  }
  if (!set) return set;
  if (says_allowed) setting.threshold.allowed = options.allowed;
  setting.is_on = options.severity != "off";
  if (setting.is_on) setting.severity = severity_of(options.severity);
  const YamlNode* at_limits = node.find("at_limits");
  return at_limits ? read_at_limits(*at_limits, setting.threshold) : Result<void>();
}

std::vector<std::string> ids_of(const GateSettings& settings) {
  std::vector<std::string> ids;
  for (const auto& [id, setting] : settings.rules) ids.push_back(id);
  return ids;
}

Result<void> read_rules(const YamlNode& node, GateSettings& settings) {
  std::vector<OptionField> none;
  SIGHTLINE_TRY(set_fields(node, "rules", none, ids_of(settings)));
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string& id = node.keys[i].scalar;
    SIGHTLINE_TRY(read_rule(node.values[i], id, settings.rules[id]));
  }
  return {};
}

Result<RoutePlace> read_route(const YamlNode& node) {
  RouteOptions options;
  std::vector<OptionField> fields = option_fields(options);
  SIGHTLINE_TRY(set_fields(node, "route", fields));
  if (!node.find("from_m") || !node.find("to_m")) {
    return refused(node, "route: from_m and to_m are required", ErrorCode::kMissingKey);
  }
  if (options.to_s_m < options.from_s_m) return refused(node, "route: to_m lies before from_m");
  return RoutePlace{static_cast<std::uint32_t>(options.run), options.from_s_m, options.to_s_m};
}

using Place = decltype(GateException::place);

Result<Place> read_circle(const YamlNode& node) {
  SIGHTLINE_ASSIGN(const std::vector<double> v, read_numbers(node, "circle: [x, y, radius]", 3));
  if (!(v[2] > 0.0)) return refused(node, "circle: expected a radius above 0");
  return Place(CirclePlace{{v[0], v[1]}, v[2]});
}

Result<Place> read_box(const YamlNode& node) {
  SIGHTLINE_ASSIGN(const std::vector<double> v, read_numbers(node, "box: [x0, y0, x1, y1]", 4));
  if (v[2] < v[0] || v[3] < v[1]) {
    return refused(node, "box: x1 or y1 is less than x0 or y0");
  }
  return Place(BoxPlace{{v[0], v[1]}, {v[2], v[3]}});
}

Result<Place> read_place(const YamlNode& node) {
  const YamlNode* circle = node.find("circle");
  const YamlNode* box = node.find("box");
  const YamlNode* route = node.find("route");
  if ((circle ? 1 : 0) + (box ? 1 : 0) + (route ? 1 : 0) > 1) {
    return refused(node, "an exception has one place: circle, box or route");
  }
  if (circle) return read_circle(*circle);
  if (box) return read_box(*box);
  if (!route) return Place(WholeMap{});
  SIGHTLINE_ASSIGN(const RoutePlace place, read_route(*route));
  return Place(place);
}

Result<GateException> read_exception(const YamlNode& node, const GateSettings& settings) {
  ExceptionOptions options;
  std::vector<OptionField> fields = option_fields(options);
  SIGHTLINE_TRY(set_fields(node, "an exception", fields, {"circle", "box", "route"}));
  for (const auto& [key, value] :
       {std::pair("rule", &options.rule), std::pair("reason", &options.reason),
        std::pair("until", &options.until)}) {
    if (!value->empty()) continue;
    return refused(node, std::string("an exception needs '") + key + "'", ErrorCode::kMissingKey);
  }
  if (options.rule != "*" && !settings.rules.contains(options.rule)) {
    return placed(unknown_key(options.rule, "in rule of an exception", ids_of(settings)),
                  *node.find("rule"));
  }
  if (!is_date(options.until)) {
    return refused(*node.find("until"),
                   "until: found '" + options.until + "', expected a day as YYYY-MM-DD");
  }
  SIGHTLINE_ASSIGN(const Place place, read_place(node));
  GateException exception{options.rule, std::nullopt, place, options.reason, options.until};
  if (node.find("limit_m")) exception.limit_m = options.limit_m;
  return exception;
}

Result<void> read_exceptions(const YamlNode& node, GateSettings& settings) {
  if (node.kind != YamlNode::Kind::kList) return refused(node, "exceptions must be a list");
  for (const YamlNode& item : node.values) {
    SIGHTLINE_ASSIGN(const GateException exception, read_exception(item, settings));
    settings.exceptions.push_back(exception);
  }
  return {};
}

Result<void> read_section(const YamlNode& node, GateSettings& settings) {
  GateOptions options = options_of(settings);
  std::vector<OptionField> fields = option_fields(options);
  Result<void> read = set_fields(node, "section 'gate'", fields, {"rules", "exceptions"});
  settings.stretch_m = options.stretch_m;
  settings.change_stretch_m = options.change_stretch_m;
  settings.fails_at = severity_of(options.fails_at);
  const YamlNode* rules = node.find("rules");
  if (read && rules) read = read_rules(*rules, settings);
  const YamlNode* exceptions = node.find("exceptions");
  if (read && exceptions) read = read_exceptions(*exceptions, settings);
  return read;
}

// The section to read: that of a file of sections, or the file itself where it is nothing else;
// nullptr where a compile's configuration says nothing of the gate.
const YamlNode* section_in(const YamlNode& root) {
  const YamlNode* section = root.find("gate");
  if (section) return section;
  return root.find("mapping") || root.find("map") ? nullptr : &root;
}

}  // namespace

Result<GateSettings> parse_gate_settings(const std::string& yaml) {
  SIGHTLINE_ASSIGN(const YamlNode root, parse_yaml(yaml));
  GateSettings settings = default_gate_settings();
  const YamlNode* section = section_in(root);
  if (!section) return settings;
  SIGHTLINE_TRY(read_section(*section, settings));
  return settings;
}

Result<GateSettings> read_gate_settings(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_yaml_text(file));
  Result<GateSettings> settings = parse_gate_settings(text);
  if (settings) return settings;
  Error error = settings.error();
  error.file = file.string();
  return error;
}

}  // namespace sightline
