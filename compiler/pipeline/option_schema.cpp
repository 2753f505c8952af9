#include "compiler/pipeline/option_schema.h"

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json json_value(const OptionField& field) {
  if (std::holds_alternative<EnumValue>(field.value)) return to_text(field);
  if (bool* const* value = std::get_if<bool*>(&field.value)) return **value;
  if (int* const* value = std::get_if<int*>(&field.value)) return **value;
  if (double* const* value = std::get_if<double*>(&field.value)) return **value;
  if (std::string* const* value = std::get_if<std::string*>(&field.value)) return **value;
  if (std::vector<Look>* const* value = std::get_if<std::vector<Look>*>(&field.value)) {
    if ((*value)->empty()) return to_text(field);
    Json texts = Json::array();
    for (const Look& look : **value) texts.push_back(to_text(look));
    return texts;
  }
  return *std::get<std::vector<double>*>(field.value);
}

Json number_schema(const OptionField& field, const char* type) {
  return {{"type", type}, {"minimum", field.minimum}, {"maximum", field.maximum}};
}

Json field_schema(const OptionField& field) {
  Json schema;
  if (std::holds_alternative<bool*>(field.value)) {
    schema["type"] = "boolean";
  } else if (std::holds_alternative<int*>(field.value)) {
    schema = number_schema(field, "integer");
  } else if (std::holds_alternative<double*>(field.value)) {
    schema = number_schema(field, "number");
  } else if (std::holds_alternative<std::string*>(field.value) ||
             std::holds_alternative<EnumValue>(field.value)) {
    schema["type"] = "string";
    if (!field.choices.empty()) {
      schema["enum"] = field.choices;
    } else {
      schema["type"] = {"string", "number"};  // `columns: 4` is a text as good as any
    }
  } else if (std::holds_alternative<std::vector<Look>*>(field.value)) {
    schema["type"] = {"array", "string"};
    schema["items"] = {{"type", "string"}};
    schema["minItems"] = 1;
  } else {
    schema = {{"type", "array"}, {"items", number_schema(field, "number")}, {"minItems", 1}};
  }
  schema["description"] = field.help;
  schema["default"] = json_value(field);
  return schema;
}

}  // namespace

// A path need not be UTF-8; what is none of it is replaced.
std::string json_text(const OptionField& field) {
  return json_value(field).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string properties_schema(const std::vector<OptionField>& fields) {
  Json properties = Json::object();
  for (const OptionField& field : fields) properties[field.name] = field_schema(field);
  return properties.dump();
}

}  // namespace sightline
