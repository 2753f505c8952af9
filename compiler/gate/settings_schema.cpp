#include <nlohmann/json.hpp>

#include "compiler/gate/settings.h"
#include "compiler/gate/settings_fields.h"
#include "compiler/pipeline/option_yaml.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json object_of(Json properties) {
  return {
      {"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
}

// Of fields without a default of their own: each rule has another, and exceptions have none.
template <class Options>
Json properties_of(Options options) {
  Json properties = Json::parse(properties_schema(option_fields(options)));
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
  Json full = properties_of(RuleOptions());
  const Json short_forms = Json::array({full["allowed"], full["severity"]});
  full["at_limits"] = {{"type", "object"}, {"additionalProperties", {{"type", "number"}}}};
  Json forms = short_forms;
  forms.push_back(object_of(full));
  Json ids = Json::array();
  for (const GateRule& rule : gate_rules()) ids.push_back(rule.id);
  return {{"type", "object"},
          {"propertyNames", {{"enum", ids}}},
          {"additionalProperties", {{"anyOf", forms}}}};
}

Json exception_schema() {
  Json route = object_of(properties_of(RouteOptions()));
  route["required"] = {"from_m", "to_m"};
  Json properties = properties_of(ExceptionOptions());
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

std::string gate_settings_schema() {
  GateOptions options = options_of(default_gate_settings());
  Json properties = Json::parse(properties_schema(option_fields(options)));
  properties["rules"] = rules_schema();
  properties["exceptions"] = {{"type", "array"}, {"items", exception_schema()}};
  const Json schema = {
      {"description", "What a map must hold to pass (sightline gate, gate_rules.md)"},
      {"type", Json::array({"object", "null"})},
      {"additionalProperties", false},
      {"properties", properties}};
  return schema.dump(2);
}

}  // namespace sightline
