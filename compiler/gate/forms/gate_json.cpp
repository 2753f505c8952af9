#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compiler/gate/forms/gate_text.h"
#include "compiler/gate/rules/rules.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/version.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json card_json(const GateMapCard& card) {
  return {{"file", card.file},
          {"map_id", card.map_id},
          {"version", card.version},
          {"release", card.release},
          {"root_digest", card.root_digest}};
}

Json point_json(const Eigen::Vector3d& p_m) { return Json::array({p_m.x(), p_m.y(), p_m.z()}); }

Json place_json(const RouteStretch& place) {
  return {{"of_old_map", place.is_of_old},
          {"first_site", place.first_site},
          {"last_site", place.last_site},
          {"run", place.run},
          {"first_s_m", place.first_s_m},
          {"last_s_m", place.last_s_m},
          {"middle_map_m", point_json(place.middle_map_m)},
          {"middle_world_m", point_json(place.middle_world_m)}};
}

Json check_json(const Check& check) {
  Json json = {{"rule", check.rule},
               {"severity", severity_name(check.severity)},
               {"verdict", verdict_name(check.verdict)},
               {"limit_m", check.limit_m ? Json(*check.limit_m) : Json()},
               {"found", check.found},
               {"allowed", check.allowed ? Json(*check.allowed) : Json()},
               {"unit", check.unit},
               {"place", check.place ? place_json(*check.place) : Json()},
               {"message", check.message}};
  if (!check.exception.empty()) json["exception"] = check.exception;
  return json;
}

// A path as a relative reference, or as a file URI where it is absolute (RFC 3986).
std::string to_uri(const std::string& path) {
  static constexpr const char* kDigits = "0123456789ABCDEF";
  std::string uri = path.starts_with('/') ? "file://" : "";
  for (const char c : path) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') ||
                          std::string_view("/-._~").find(c) != std::string_view::npos;
    if (is_plain) {
      uri += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    uri += {'%', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return uri;
}

Json text(std::string_view words) { return {{"text", words}}; }

// How a person goes on from here.
Json help_of(const GateRule& rule) {
  const std::string bound = rule.bound == Bound::kAtMost ? "at most" : "at least";
  const std::string usual =
      rule.allowed ? concat("Allowed is ", bound, " ", in_words(*rule.allowed, rule.unit),
                            " unless the configuration sets another bound.")
                   : "There is no bound unless the configuration sets one.";
  const std::string how =
      "`sightline inspect MAP --site N` shows why a place has its range, `sightline report` shows "
      "it. To set another bound, or an exception for a place with a reason and an end, use "
      "`gate:` in the configuration.";
  return {
      {"text", concat(rule.summary, ". ", usual, " ", how)},
      {"markdown", concat("**", rule.id, "**: ", rule.summary, ". ", usual, "\n\n", how,
                          "\n\n```yaml\ngate:\n  rules:\n    ", rule.id, ": {allowed: ...}\n```")}};
}

Json rules_json() {
  Json rules = Json::array();
  for (const GateRule& rule : gate_rules()) {
    Json json = {
        {"id", rule.id},
        {"shortDescription", text(rule.summary)},
        {"help", help_of(rule)},
        {"defaultConfiguration", {{"level", severity_name(rule.severity)}}},
        {"properties",
         {{"unit", rule.unit}, {"bound", rule.bound == Bound::kAtMost ? "at most" : "at least"}}}};
    if (rule.allowed) json["properties"]["allowed"] = *rule.allowed;
    rules.push_back(json);
  }
  return rules;
}

std::size_t rule_index(const std::string& id) {
  const auto found = std::ranges::find(gate_rules(), id, &GateRule::id);
  return static_cast<std::size_t>(found - gate_rules().begin());
}

Json location_of(const GateReport& report, const Check& check) {
  const bool is_of_old = check.place && check.place->is_of_old && report.old_map;
  const std::string& map_file = is_of_old ? report.old_map->file : report.map.file;
  // Code scanning shows text beside a line: that of the rules. A map has neither.
  const bool has_rules = !report.rules_file.empty();
  Json location = {
      {"physicalLocation",
       {{"artifactLocation", {{"uri", to_uri(has_rules ? report.rules_file : map_file)}}},
        {"region", {{"startLine", has_rules ? report.rules_line : 1}}}}},
      {"message", text("of the map " + map_file)}};
  if (!check.place) return location;
  const RouteStretch& place = *check.place;
  location["logicalLocations"] =
      Json::array({{{"name", fmt::format("sites {} to {}", place.first_site, place.last_site)},
                    {"fullyQualifiedName",
                     fmt::format("run {}/{} to {} m", place.run, format_double(place.first_s_m),
                                 format_double(place.last_s_m))},
                    {"kind", "route"}}});
  return location;
}

std::string fingerprint(const Check& check) {
  std::string print = check.rule;
  if (check.limit_m) print += "/" + format_double(*check.limit_m);
  if (!check.place) return print;
  constexpr double kSame_m = 50.0;
  const Eigen::Vector3d& p_m = check.place->middle_world_m;
  return fmt::format("{}/{},{}", print, static_cast<long>(std::floor(p_m.x() / kSame_m)),
                     static_cast<long>(std::floor(p_m.y() / kSame_m)));
}

Json properties_of(const Check& check) {
  Json json = {{"found", check.found}, {"unit", check.unit}};
  if (check.allowed) json["allowed"] = *check.allowed;
  if (check.limit_m) json["limit_m"] = *check.limit_m;
  if (!check.place) return json;
  json["first_site"] = check.place->first_site;
  json["last_site"] = check.place->last_site;
  json["middle_world_m"] = point_json(check.place->middle_world_m);
  return json;
}

Json result_of(const GateReport& report, const Check& check) {
  Json json = {{"ruleId", check.rule},
               {"ruleIndex", rule_index(check.rule)},
               {"level", severity_name(check.severity)},
               {"message", text(check.message)},
               {"locations", Json::array({location_of(report, check)})},
               {"partialFingerprints", {{"sightlinePlace/v1", fingerprint(check)}}},
               {"properties", properties_of(check)}};
  if (check.verdict == Verdict::kExcepted) {
    json["suppressions"] =
        Json::array({{{"kind", "external"}, {"justification", check.exception}}});
  }
  return json;
}

}  // namespace

std::string to_json(const GateReport& report) {
  Json json = {{"schema", 1},
               {"map", card_json(report.map)},
               {"old_map", report.old_map ? card_json(*report.old_map) : Json()},
               {"today", report.today},
               {"verdict", to_json(report.verdict)},
               {"passed", report.passes()},
               {"fails_at", severity_name(report.fails_at)},
               {"errors", report.violations(Severity::kError)},
               {"warnings", report.violations(Severity::kWarning)},
               {"notes", report.violations(Severity::kNote)},
               {"excepted", report.count(Verdict::kExcepted)},
               {"checks", Json::array()}};
  for (const Check& check : report.checks) json["checks"].push_back(check_json(check));
  return json_text(json);
}

std::string to_sarif(const GateReport& report) {
  Json results = Json::array();
  for (const Check& check : report.checks) {
    if (check.verdict == Verdict::kViolated || check.verdict == Verdict::kExcepted) {
      results.push_back(result_of(report, check));
    }
  }
  // The form asks for a version of three numbers (semver.org).
  const Json driver = {{"name", "sightline gate"},
                       {"version", program_version()},
                       {"semanticVersion", program_version()},
                       {"rules", rules_json()}};
  const Json run = {{"tool", {{"driver", driver}}},
                    {"automationDetails", {{"id", "sightline/" + report.map.map_id}}},
                    {"invocations", Json::array({{{"executionSuccessful", true}}})},
                    {"columnKind", "utf16CodeUnits"},
                    {"results", results},
                    {"properties",
                     {{"map_verdict", word_of(report.verdict.verdict)},
                      {"map_version", report.map.version},
                      {"map_release", report.map.release},
                      {"map_root_digest", report.map.root_digest}}}};
  const Json log = {{"$schema", "https://json.schemastore.org/sarif-2.1.0.json"},
                    {"version", "2.1.0"},
                    {"runs", Json::array({run})}};
  return json_text(log);
}

}  // namespace sightline
