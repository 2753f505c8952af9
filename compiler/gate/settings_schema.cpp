#include <nlohmann/json.hpp>

#include "compiler/gate/settings.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(std::size_t count, const char* what) {
  return {{"type", "array"},
          {"items", {{"type", "number"}}},
          {"minItems", count},
          {"maxItems", count},
          {"description", what}};
}

Json positive(double by_default, const char* what) {
  return {{"type", "number"},
          {"exclusiveMinimum", 0},
          {"default", by_default},
          {"description", what}};
}

// A threshold, a severity, or both.
Json rules_schema() {
  const Json severity = {{"enum", {"error", "warning", "note", "off"}}};
  const Json full = {{"type", "object"},
                     {"additionalProperties", false},
                     {"properties",
                      {{"severity", severity},
                       {"allowed", {{"type", "number"}}},
                       {"at_limits",
                        {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}}}}}};
  Json ids = Json::array();
  for (const GateRule& rule : gate_rules()) ids.push_back(rule.id);
  return {{"type", "object"},
          {"propertyNames", {{"enum", ids}}},
          {"additionalProperties",
           {{"anyOf", Json::array({{{"type", "number"}}, severity, full})}}}};
}

Json exception_schema() {
  const Json route = {{"type", "object"},
                      {"additionalProperties", false},
                      {"required", {"from_m", "to_m"}},
                      {"properties",
                       {{"run", {{"type", "integer"}, {"minimum", 0}}},
                        {"from_m", {{"type", "number"}}},
                        {"to_m", {{"type", "number"}}}}}};
  const Json text = {{"type", "string"}, {"minLength", 1}};
  return {{"type", "object"},
          {"additionalProperties", false},
          {"required", {"rule", "reason", "until"}},
          {"properties",
           {{"rule", text},
            {"limit_m", {{"type", "number"}, {"exclusiveMinimum", 0}}},
            {"circle", numbers(3, "x, y and radius, m, in world coordinates")},
            {"box", numbers(4, "x0, y0, x1, y1, m, in world coordinates")},
            {"route", route},
            {"reason", text},
            {"until",
             {{"type", "string"},
              {"pattern", "^[0-9]{4}-[0-9]{2}-[0-9]{2}$"},
              {"description", "the last day that it covers"}}}}}};
}

}  // namespace

std::string gate_settings_schema() {
  const GateSettings defaults = default_gate_settings();
  const Json schema = {
      {"description", "What a map must hold to pass (sightline gate, gate_rules.md)"},
      {"type", Json::array({"object", "null"})},
      {"additionalProperties", false},
      {"properties",
       {{"stretch_m", positive(defaults.stretch_m, "route that is judged at a time, m")},
        {"change_stretch_m",
         positive(defaults.change_stretch_m, "route whose change is judged at a time, m")},
        {"fails_at",
         {{"enum", {"error", "warning", "note"}},
          {"default", severity_name(defaults.fails_at)},
          {"description", "the least severity of a finding that fails the gate"}}},
        {"rules", rules_schema()},
        {"exceptions", {{"type", "array"}, {"items", exception_schema()}}}}}};
  return schema.dump(2);
}

}  // namespace sightline
