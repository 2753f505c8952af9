#include "compiler/gate/settings.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "compiler/gate/rules/rules.h"
#include "compiler/pipeline/option_yaml.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/text/json_text.h"
#include "formats/text/numbers.h"
#include "passes/pass/options.h"

namespace sightline {
namespace {

using Fields = std::vector<OptionField>;

Fields section_fields(GateSettings& settings, std::string& fails_at) {
  return {number("stretch_m", settings.stretch_m, "route that is judged at a time, m", 0.1, 1e6),
          number("change_stretch_m", settings.change_stretch_m,
                 "route whose change is judged at a time, m", 0.1, 1e6),
          choice("fails_at", fails_at, "the least severity of a finding that fails the gate",
                 {"error", "warning", "note"})};
}

Fields rule_fields(std::string& severity, double& allowed) {
  return {choice("severity", severity, "of a violation; off: the rule is not judged",
                 {"error", "warning", "note", "off"}),
          number("allowed", allowed, "the threshold, in the rule's unit", -1e12, 1e12)};
}

Fields exception_fields(GateException& exception, double& limit_m) {
  return {text("rule", exception.rule, "id of the rule; *: every rule"),
          number("limit_m", limit_m, "the limit; without it every limit", 0.001, 1000.0),
          text("reason", exception.reason, "why; reports print it"),
          text("until", exception.until, "the last day on which it applies, YYYY-MM-DD")};
}

Fields route_fields(RoutePlace& place, int& run) {
  return {integer("run", run, "of the route, from 0", 0, 2'000'000'000),
          number("from_m", place.from_s_m, "way along the run where it begins, m", -1e9, 1e9),
          number("to_m", place.to_s_m, "where it ends, m", -1e9, 1e9)};
}

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
    return refused(node, concat(what, ": expected a list of ", count, " numbers"));
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

std::string_view unit_of(const std::string& id) {
  const auto rule = std::ranges::find(gate_rules(), id, &GateRule::id);
  return rule == gate_rules().end() ? std::string_view() : rule->unit;
}

// "95 %" as 0.95, wherever the threshold of a rule that judges a share may be written.
YamlNode with_percents_as_shares(YamlNode node) {
  if (node.kind == YamlNode::Kind::kScalar && node.scalar.ends_with('%')) {
    const std::string number = node.scalar.substr(0, node.scalar.find_last_not_of(" %") + 1);
    const std::optional<double> percents = finite_number(number);
    if (percents) node.scalar = format_double(*percents / 100.0);
  }
  for (YamlNode& value : node.values) value = with_percents_as_shares(std::move(value));
  return node;
}

Result<void> check_share(const YamlNode& node, const std::string& id, double allowed) {
  if (unit_of(id) != "share" || allowed <= 1.0) return {};
  return refused(node, concat("rule '", id, "' judges a share: ", format_double(allowed),
                              " is more than all; write ", format_double(allowed / 100.0), " or ",
                              format_double(allowed), " %"));
}

Result<void> read_at_limits(const YamlNode& node, const std::string& id, Threshold& threshold) {
  if (node.kind != YamlNode::Kind::kMap) {
    return refused(node, "at_limits must be a map of limits");
  }
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    SIGHTLINE_ASSIGN(const double limit_m, read_number(node.keys[i], "a limit of at_limits", 1e-6));
    SIGHTLINE_ASSIGN(const double allowed, read_number(node.values[i], "at_limits", -1e12));
    SIGHTLINE_TRY(check_share(node.values[i], id, allowed));
    threshold.at_limits.emplace_back(limit_m, allowed);
  }
  return {};
}

// `rule: 0.9`, `rule: 90 %`, `rule: warning`, `rule: off` or
// `rule: {severity: .., allowed: .., at_limits: ..}`.
Result<void> read_rule(const YamlNode& written, const std::string& id, RuleSetting& setting) {
  const YamlNode node = unit_of(id) == "share" ? with_percents_as_shares(written) : written;
  if (node.kind == YamlNode::Kind::kNull)
    return refused(node, concat("rule '", id, "' has no value: give a threshold or a severity"));
  std::string severity(severity_name(setting.severity));
  double allowed = 0.0;
  Fields fields = rule_fields(severity, allowed);
  bool says_allowed = node.find("allowed") != nullptr;
  Result<void> set;
  if (node.kind == YamlNode::Kind::kScalar) {
    set = set_field(node, fields[1]);
    says_allowed = set.has_value();
    if (!set) set = set_field(node, fields[0]);
  } else {
    set = set_fields(node, concat("rule '", id, "'"), fields, {"at_limits"});
  }
  if (!set) return set;
  if (says_allowed) {
    SIGHTLINE_TRY(check_share(node, id, allowed));
    setting.threshold.allowed = allowed;
  }
  setting.is_on = severity != "off";
  if (setting.is_on) setting.severity = severity_of(severity);
  const YamlNode* at_limits = node.find("at_limits");
  return at_limits ? read_at_limits(*at_limits, id, setting.threshold) : Result<void>();
}

std::vector<std::string> ids_of(const GateSettings& settings) {
  std::vector<std::string> ids;
  for (const auto& [id, setting] : settings.rules) ids.push_back(id);
  return ids;
}

Result<void> read_rules(const YamlNode& node, GateSettings& settings) {
  Fields none;
  SIGHTLINE_TRY(set_fields(node, "rules", none, ids_of(settings)));
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const std::string& id = node.keys[i].scalar;
    SIGHTLINE_TRY(read_rule(node.values[i], id, settings.rules[id]));
  }
  return {};
}

Result<RoutePlace> read_route(const YamlNode& node) {
  RoutePlace place;
  int run = 0;
  Fields fields = route_fields(place, run);
  SIGHTLINE_TRY(set_fields(node, "route", fields));
  if (!node.find("from_m") || !node.find("to_m")) {
    return refused(node, "route: from_m and to_m are required", ErrorCode::kMissingKey);
  }
  if (place.to_s_m < place.from_s_m) return refused(node, "route: to_m is less than from_m");
  place.run = static_cast<std::uint32_t>(run);
  return place;
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
  GateException exception;
  double limit_m = 0.0;
  Fields fields = exception_fields(exception, limit_m);
  SIGHTLINE_TRY(set_fields(node, "an exception", fields, {"circle", "box", "route"}));
  for (const auto& [key, value] :
       {std::pair("rule", &exception.rule), std::pair("reason", &exception.reason),
        std::pair("until", &exception.until)}) {
    if (!value->empty()) continue;
    return refused(node, concat("an exception needs '", key, "'"), ErrorCode::kMissingKey);
  }
  if (exception.rule != "*" && !settings.rules.contains(exception.rule)) {
    return placed(unknown_key(exception.rule, "in rule of an exception", ids_of(settings)),
                  *node.find("rule"));
  }
  if (!is_date(exception.until)) {
    return refused(*node.find("until"),
                   concat("until: found '", exception.until, "', expected a day as YYYY-MM-DD"));
  }
  SIGHTLINE_ASSIGN(exception.place, read_place(node));
  if (node.find("limit_m")) exception.limit_m = limit_m;
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

// A rule beside `rules` instead of in it.
Result<void> check_no_rule_is_outside(const YamlNode& node, const GateSettings& settings) {
  for (const YamlNode& key : node.keys) {
    if (!settings.rules.contains(key.scalar)) continue;
    return refused(key, concat("'", key.scalar, "' is a rule and belongs under gate.rules"),
                   ErrorCode::kUnknownKey);
  }
  return {};
}

Result<void> read_section(const YamlNode& node, GateSettings& settings) {
  SIGHTLINE_TRY(check_no_rule_is_outside(node, settings));
  std::string fails_at(severity_name(settings.fails_at));
  Fields fields = section_fields(settings, fails_at);
  Result<void> read = set_fields(node, "section 'gate'", fields, {"rules", "exceptions"});
  settings.fails_at = severity_of(fails_at);
  const YamlNode* rules = node.find("rules");
  if (read && rules) read = read_rules(*rules, settings);
  const YamlNode* exceptions = node.find("exceptions");
  if (read && exceptions) read = read_exceptions(*exceptions, settings);
  return read;
}

// The section to read: that of a file of sections, or the file itself where it is nothing else;
// nullptr where a compile's configuration has no such section.
const YamlNode* section_in(const YamlNode& root) {
  if (const YamlNode* section = root.find("gate")) return section;
  return root.find("mapping") || root.find("map") ? nullptr : &root;
}

using Json = nlohmann::ordered_json;

Json object_of(Json properties) {
  return {
      {"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
}

// Of fields without a default of their own: each rule has another, and exceptions have none.
Json properties_of(const Fields& fields) {
  Json properties = Json::parse(properties_schema(fields));
  for (Json& property : properties) property.erase("default");
  return properties;
}

Json numbers(std::size_t count, const char* what) {
  return {{"type", "array"},
          {"items", {{"type", "number"}}},
          {"minItems", count},
          {"maxItems", count},
          {"description", what}};
}

// A threshold, a severity, or both.
Json rules_schema() {
  std::string severity;
  double allowed = 0.0;
  Json full = properties_of(rule_fields(severity, allowed));
  const Json percents = {{"type", "string"}, {"pattern", "^-?[0-9]+(\\.[0-9]+)? ?%$"}};
  Json forms = Json::array({full["allowed"], full["severity"], percents});
  full["allowed"] = {{"anyOf", {full["allowed"], percents}}};
  full["at_limits"] = {{"type", "object"},
                       {"additionalProperties", {{"anyOf", {{{"type", "number"}}, percents}}}}};
  forms.push_back(object_of(full));
  Json ids = Json::array();
  for (const GateRule& rule : gate_rules()) ids.push_back(rule.id);
  return {{"type", "object"},
          {"propertyNames", {{"enum", ids}}},
          {"additionalProperties", {{"anyOf", forms}}}};
}

Json exception_schema() {
  RoutePlace place;
  int run = 0;
  Json route = object_of(properties_of(route_fields(place, run)));
  route["required"] = {"from_m", "to_m"};
  GateException exception;
  double limit_m = 0.0;
  Json properties = properties_of(exception_fields(exception, limit_m));
  properties["rule"]["minLength"] = 1;
  properties["reason"]["minLength"] = 1;
  properties["until"]["pattern"] = "^[0-9]{4}-[0-9]{2}-[0-9]{2}$";
  properties["circle"] = numbers(3, "x, y and radius, m, in world coordinates");
  properties["box"] = numbers(4, "x0, y0, x1, y1, m, in world coordinates");
  properties["route"] = route;
  Json schema = object_of(properties);
  schema["required"] = {"rule", "reason", "until"};
  return schema;
}

}  // namespace

bool is_date(std::string_view text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  int used = 0;
  const std::string copy(text);
  if (copy.size() != 10 ||
      std::sscanf(copy.c_str(), "%4d-%2u-%2u%n", &year, &month, &day, &used) != 3 || used != 10) {
    return false;
  }
  return std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(month),
                                     std::chrono::day(day))
      .ok();
}

int days_between(std::string_view from, std::string_view to) {
  const auto day_of = [](std::string_view text) {
    const std::string copy(text);
    const int year = std::stoi(copy.substr(0, 4));
    const auto month = static_cast<unsigned>(std::stoi(copy.substr(5, 2)));
    const auto day = static_cast<unsigned>(std::stoi(copy.substr(8, 2)));
    return std::chrono::sys_days(std::chrono::year_month_day(
        std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)));
  };
  return static_cast<int>((day_of(to) - day_of(from)).count());
}

GateSettings default_gate_settings() {
  GateSettings settings;
  for (const GateRule& rule : gate_rules()) {
    settings.rules[std::string(rule.id)] = {true, rule.severity, {rule.allowed, {}}};
  }
  return settings;
}

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
  if (!settings) return in_file(settings.error(), file.string());
  return settings;
}

std::string gate_settings_schema() {
  GateSettings settings = default_gate_settings();
  std::string fails_at(severity_name(settings.fails_at));
  Json properties = Json::parse(properties_schema(section_fields(settings, fails_at)));
  properties["rules"] = rules_schema();
  properties["exceptions"] = {{"type", "array"}, {"items", exception_schema()}};
  const Json schema = {
      {"description", "Requirements that a map must meet (sightline gate, gate_rules.md)"},
      {"type", Json::array({"object", "null"})},
      {"additionalProperties", false},
      {"properties", properties}};
  return json_text(schema, -1);
}

}  // namespace sightline
