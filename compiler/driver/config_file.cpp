#include "compiler/driver/config_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "compiler/base/atomic_file.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const YAML::Mark& mark) { return "line " + std::to_string(mark.line + 1); }

Error unknown_key(std::string_view key, std::string_view where,
                  const std::vector<std::string>& known) {
  std::string message = "unknown key '" + std::string(key) + "' " + std::string(where);
  const std::string near = nearest_name(key, known);
  if (!near.empty()) {
    message += "; did you mean '" + near + "'?";
  } else {
    message += "; known are:";
    for (const std::string& name : known) message += " " + name;
  }
  return {ErrorCode::kUnknownKey, message, "", ""};
}

Result<ConfigSection*> find_section(std::string_view name, std::vector<ConfigSection>& sections) {
  std::vector<std::string> known;
  for (ConfigSection& section : sections) {
    if (section.name == name) return &section;
    known.push_back(section.name);
  }
  return unknown_key(name, "at the top level", known);
}

Result<OptionField*> find_field(std::string_view name, ConfigSection& section) {
  std::vector<std::string> known;
  for (OptionField& field : section.fields) {
    if (field.name == name) return &field;
    known.push_back(field.name);
  }
  return unknown_key(name, "in section '" + section.name + "'", known);
}

Error placed(Error error, const std::filesystem::path& file, const YAML::Mark& mark) {
  error.file = file.string();
  error.place = line_of(mark);
  return error;
}

// A scalar as it stands, a sequence of scalars as "a, b, c"; anything deeper is no value of ours.
Result<std::string> text_of(const YAML::Node& node) {
  if (node.IsNull()) return std::string();
  if (node.IsScalar()) return node.Scalar();
  if (!node.IsSequence()) {
    return Error{ErrorCode::kBadValue, "found a map, expected a value or a list of values", "", ""};
  }
  std::string text;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) {
      return Error{ErrorCode::kBadValue, "found a nested list, expected a list of values", "", ""};
    }
    text += (text.empty() ? "" : ", ") + item.Scalar();
  }
  return text;
}

Result<void> read_section(const std::filesystem::path& file, const YAML::Node& node,
                          ConfigSection& section) {
  if (node.IsNull()) return {};
  if (!node.IsMap()) {
    return Error{ErrorCode::kBadValue, "section '" + section.name + "' must be a map of keys",
                 file.string(), line_of(node.Mark())};
  }
  for (const auto& entry : node) {
    const Result<OptionField*> field = find_field(entry.first.Scalar(), section);
    if (!field) return placed(field.error(), file, entry.first.Mark());
    const Result<std::string> text = text_of(entry.second);
    if (!text) return placed(text.error(), file, entry.second.Mark());
    const Result<void> set = set_from_text(**field, *text);
    if (!set) return placed(set.error(), file, entry.second.Mark());
  }
  return {};
}

Result<YAML::Node> parse(const std::filesystem::path& file) {
  const Result<std::string> text = read_text_file(file);
  if (!text) return text.error();
  try {
    return YAML::Load(*text);
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, "not YAML: " + exception.msg, file.string(),
                 line_of(exception.mark)};
  }
}

// A value in the words of both YAML and JSON.
Json json_value(const OptionField& field) {
  if (bool* const* value = std::get_if<bool*>(&field.value)) return **value;
  if (int* const* value = std::get_if<int*>(&field.value)) return **value;
  if (double* const* value = std::get_if<double*>(&field.value)) return **value;
  if (std::string* const* value = std::get_if<std::string*>(&field.value)) return **value;
  if (std::holds_alternative<EnumValue>(field.value)) return to_text(field);
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
    if (!field.choices.empty()) schema["enum"] = field.choices;
  } else {
    schema = {{"type", "array"}, {"items", number_schema(field, "number")}, {"minItems", 1}};
  }
  schema["description"] = field.help;
  schema["default"] = json_value(field);
  return schema;
}

}  // namespace

std::vector<ConfigSection> sections_of(const Plan& plan) {
  std::vector<ConfigSection> sections;
  for (const PassSection& pass : plan.sections()) {
    sections.push_back({pass.name, pass.help, pass.fields, {}, pass.options});
  }
  return sections;
}

PassSettings settings_of(const std::vector<ConfigSection>& sections) {
  PassSettings settings;
  for (const ConfigSection& section : sections) {
    if (!section.options) continue;
    for (const OptionField& field : section.fields) {
      settings.own[section.name][field.name] = to_text(field);
    }
  }
  return settings;
}

Result<void> read_yaml(const std::filesystem::path& file, std::vector<ConfigSection>& sections) {
  const Result<YAML::Node> root = parse(file);
  if (!root) return root.error();
  if (!root->IsMap()) {
    return Error{ErrorCode::kMalformedText, "a configuration is a map of sections", file.string(),
                 "line 1"};
  }
  try {
    for (const auto& entry : *root) {
      const Result<ConfigSection*> section = find_section(entry.first.Scalar(), sections);
      if (!section) return placed(section.error(), file, entry.first.Mark());
      if (!(*section)->schema.empty()) continue;
      const Result<void> read = read_section(file, entry.second, **section);
      if (!read) return read;
    }
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, exception.msg, file.string(), line_of(exception.mark)};
  }
  return {};
}

Result<void> set_override(std::string_view assignment, std::vector<ConfigSection>& sections) {
  const std::size_t equals = assignment.find('=');
  const std::size_t dot = assignment.substr(0, equals).find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos) {
    return Error{ErrorCode::kBadArgument,
                 "found '" + std::string(assignment) + "', expected section.key=value", "--set",
                 ""};
  }
  const Result<ConfigSection*> section = find_section(assignment.substr(0, dot), sections);
  if (!section) return section.error();
  const Result<OptionField*> field =
      find_field(assignment.substr(dot + 1, equals - dot - 1), **section);
  if (!field) return field.error();
  return set_from_text(**field, assignment.substr(equals + 1));
}

std::string to_yaml(const std::vector<ConfigSection>& sections) {
  std::string text;
  for (const ConfigSection& section : sections) {
    if (section.fields.empty()) continue;
    text += "# " + section.help + "\n" + section.name + ":\n";
    for (const OptionField& field : section.fields) {
      text += "  # " + field.help + "\n  " + field.name + ": " + json_value(field).dump() + "\n";
    }
    text += "\n";
  }
  return text;
}

std::string to_json_schema(const std::vector<ConfigSection>& sections) {
  Json root = {{"$schema", "http://json-schema.org/draft-07/schema#"},
               {"title", "sightline configuration"},
               {"type", "object"},
               {"additionalProperties", false},
               {"properties", Json::object()}};
  for (const ConfigSection& section : sections) {
    if (!section.schema.empty()) {
      root["properties"][section.name] = Json::parse(section.schema);
      continue;
    }
    Json schema = {{"description", section.help},
                   {"type", Json::array({"object", "null"})},
                   {"additionalProperties", false},
                   {"properties", Json::object()}};
    for (const OptionField& field : section.fields) {
      schema["properties"][field.name] = field_schema(field);
    }
    root["properties"][section.name] = schema;
  }
  return root.dump(2) + "\n";
}

}  // namespace sightline
