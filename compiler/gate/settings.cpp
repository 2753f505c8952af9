#include "compiler/gate/settings.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "compiler/base/atomic_file.h"
#include "compiler/pipeline/options.h"

namespace sightline {
namespace {

using Days = std::chrono::sys_days;

// Thrown within this file alone, so that reading nested YAML stays readable.
struct Refused {
  ErrorCode code;
  std::string message;
  YAML::Mark mark;
};

[[noreturn]] void refuse(const YAML::Node& node, const std::string& message,
                         ErrorCode code = ErrorCode::kBadValue) {
  throw Refused{code, message, node.Mark()};
}

[[noreturn]] void refuse_key(const YAML::Node& key, const std::string& where,
                             const std::vector<std::string>& known) {
  std::string message = "unknown key '" + key.Scalar() + "' in " + where;
  const std::string near = nearest_name(key.Scalar(), known);
  if (!near.empty()) {
    message += "; did you mean '" + near + "'?";
  } else {
    message += "; known are:";
    for (const std::string& name : known) message += " " + name;
  }
  refuse(key, message, ErrorCode::kUnknownKey);
}

void check_keys(const YAML::Node& node, const std::string& where,
                const std::vector<std::string>& known) {
  if (!node.IsMap()) refuse(node, where + " must be a map of keys");
  for (const auto& entry : node) {
    if (std::ranges::find(known, entry.first.Scalar()) == known.end()) {
      refuse_key(entry.first, where, known);
    }
  }
}

double read_number(const YAML::Node& node, const std::string& what) {
  double value = 0.0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    refuse(node, what + ": expected a number");
  }
  return value;
}

double read_positive(const YAML::Node& node, const std::string& what) {
  const double value = read_number(node, what);
  if (!(value > 0.0)) refuse(node, what + ": expected a number above 0");
  return value;
}

std::vector<double> read_numbers(const YAML::Node& node, const std::string& what,
                                 std::size_t count) {
  if (!node.IsSequence() || node.size() != count) {
    refuse(node, what + ": expected a list of " + std::to_string(count) + " numbers");
  }
  std::vector<double> values;
  for (const YAML::Node& item : node) values.push_back(read_number(item, what));
  return values;
}

std::optional<Severity> severity_of(const std::string& name) {
  for (const Severity severity : {Severity::kNote, Severity::kWarning, Severity::kError}) {
    if (name == severity_name(severity)) return severity;
  }
  return std::nullopt;
}

void read_severity(const YAML::Node& node, RuleSetting& setting) {
  if (node.Scalar() == "off") {
    setting.is_on = false;
    return;
  }
  const std::optional<Severity> severity = severity_of(node.Scalar());
  if (!severity) {
    refuse(node, "severity: found '" + node.Scalar() + "', expected error, warning, note or off");
  }
  setting.severity = *severity;
}

// `rule: 0.9`, `rule: warning`, `rule: off` or `rule: {severity: .., allowed: .., at_limits: ..}`.
void read_rule(const YAML::Node& node, const std::string& id, RuleSetting& setting) {
  if (node.IsScalar()) {
    double allowed = 0.0;
    if (YAML::convert<double>::decode(node, allowed) && std::isfinite(allowed)) {
      setting.threshold.allowed = allowed;
    } else {
      read_severity(node, setting);
    }
    return;
  }
  check_keys(node, "rule '" + id + "'", {"severity", "allowed", "at_limits"});
  if (node["severity"]) read_severity(node["severity"], setting);
  if (node["allowed"]) setting.threshold.allowed = read_number(node["allowed"], "allowed");
  if (!node["at_limits"]) return;
  if (!node["at_limits"].IsMap()) refuse(node["at_limits"], "at_limits must be a map of limits");
  for (const auto& entry : node["at_limits"]) {
    setting.threshold.at_limits.emplace_back(read_positive(entry.first, "a limit of at_limits"),
                                             read_number(entry.second, "at_limits"));
  }
}

void read_rules(const YAML::Node& node, GateSettings& settings) {
  if (!node.IsMap()) refuse(node, "rules must be a map of keys");
  std::vector<std::string> known;
  for (const auto& [id, setting] : settings.rules) known.push_back(id);
  check_keys(node, "rules", known);
  for (const auto& entry : node) {
    const std::string id = entry.first.Scalar();
    read_rule(entry.second, id, settings.rules[id]);
  }
}

RoutePlace read_route(const YAML::Node& node) {
  check_keys(node, "route", {"run", "from_m", "to_m"});
  RoutePlace place;
  if (!node["from_m"] || !node["to_m"]) {
    refuse(node, "route: from_m and to_m are required", ErrorCode::kMissingKey);
  }
  if (node["run"]) {
    const double run = read_number(node["run"], "run");
    if (run < 0.0 || run > 4e9 || run != std::floor(run)) {
      refuse(node["run"], "run: expected a whole number from 0");
    }
    place.run = static_cast<std::uint32_t>(run);
  }
  place.from_s_m = read_number(node["from_m"], "from_m");
  place.to_s_m = read_number(node["to_m"], "to_m");
  if (place.to_s_m < place.from_s_m) refuse(node, "route: to_m lies before from_m");
  return place;
}

void read_place(const YAML::Node& node, GateException& exception) {
  const int places = (node["circle"] ? 1 : 0) + (node["box"] ? 1 : 0) + (node["route"] ? 1 : 0);
  if (places > 1) refuse(node, "an exception has one place: circle, box or route");
  if (node["circle"]) {
    const std::vector<double> v = read_numbers(node["circle"], "circle: [x, y, radius]", 3);
    if (!(v[2] > 0.0)) refuse(node["circle"], "circle: expected a radius above 0");
    exception.place = CirclePlace{{v[0], v[1]}, v[2]};
  } else if (node["box"]) {
    const std::vector<double> v = read_numbers(node["box"], "box: [x0, y0, x1, y1]", 4);
    if (v[2] < v[0] || v[3] < v[1]) refuse(node["box"], "box: x1 or y1 is less than x0 or y0");
    exception.place = BoxPlace{{v[0], v[1]}, {v[2], v[3]}};
  } else if (node["route"]) {
    exception.place = read_route(node["route"]);
  }
}

GateException read_exception(const YAML::Node& node, const GateSettings& settings) {
  check_keys(node, "an exception",
             {"rule", "limit_m", "circle", "box", "route", "reason", "until"});
  for (const char* key : {"rule", "reason", "until"}) {
    if (!node[key] || !node[key].IsScalar() || node[key].Scalar().empty()) {
      refuse(node, std::string("an exception needs '") + key + "'", ErrorCode::kMissingKey);
    }
  }
  GateException exception;
  exception.rule = node["rule"].Scalar();
  if (exception.rule != "*" && !settings.rules.contains(exception.rule)) {
    std::vector<std::string> known;
    for (const auto& [id, setting] : settings.rules) known.push_back(id);
    refuse_key(node["rule"], "rule of an exception", known);
  }
  if (node["limit_m"]) exception.limit_m = read_positive(node["limit_m"], "limit_m");
  exception.reason = node["reason"].Scalar();
  exception.until = node["until"].Scalar();
  if (!is_date(exception.until)) {
    refuse(node["until"], "until: found '" + exception.until + "', expected a day as YYYY-MM-DD");
  }
  read_place(node, exception);
  return exception;
}

void read_section(const YAML::Node& node, GateSettings& settings) {
  if (node.IsNull()) return;
  check_keys(node, "section 'gate'",
             {"stretch_m", "change_stretch_m", "fails_at", "rules", "exceptions"});
  if (node["stretch_m"]) settings.stretch_m = read_positive(node["stretch_m"], "stretch_m");
  if (node["change_stretch_m"]) {
    settings.change_stretch_m = read_positive(node["change_stretch_m"], "change_stretch_m");
  }
  if (node["fails_at"]) {
    const std::optional<Severity> severity = severity_of(node["fails_at"].Scalar());
    if (!severity) refuse(node["fails_at"], "fails_at: expected error, warning or note");
    settings.fails_at = *severity;
  }
  if (node["rules"]) read_rules(node["rules"], settings);
  if (!node["exceptions"]) return;
  if (!node["exceptions"].IsSequence()) refuse(node["exceptions"], "exceptions must be a list");
  for (const YAML::Node& item : node["exceptions"]) {
    settings.exceptions.push_back(read_exception(item, settings));
  }
}

// Sections that only the configuration of a compile has, so that a file without `gate` that is one
// takes the defaults instead of being refused for its keys.
bool is_compile_config(const YAML::Node& root) { return root["mapping"].IsDefined(); }

std::string line_of(const YAML::Mark& mark) { return "line " + std::to_string(mark.line + 1); }

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
    return Days(std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(month),
                                            std::chrono::day(day)));
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
  GateSettings settings = default_gate_settings();
  try {
    const YAML::Node root = YAML::Load(yaml);
    if (root.IsMap() && root["gate"]) {
      read_section(root["gate"], settings);
    } else if (!root.IsMap() || !is_compile_config(root)) {
      read_section(root, settings);
    }
  } catch (const Refused& refused) {
    return Error{refused.code, refused.message, "", line_of(refused.mark)};
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, "not YAML: " + exception.msg, "",
                 line_of(exception.mark)};
  }
  return settings;
}

Result<GateSettings> read_gate_settings(const std::filesystem::path& file) {
  const Result<std::string> text = read_text_file(file);
  if (!text) return text.error();
  Result<GateSettings> settings = parse_gate_settings(*text);
  if (settings) return settings;
  Error error = settings.error();
  error.file = file.string();
  return error;
}

}  // namespace sightline
