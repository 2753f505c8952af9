#include "compiler/config/config_file.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "compiler/pipeline/option_yaml.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

Result<ConfigSection*> find_section(std::string_view name, std::vector<ConfigSection>& sections) {
  std::vector<std::string> known;
  for (ConfigSection& section : sections) {
    if (section.name == name) return &section;
    known.push_back(section.name);
  }
  Error error = unknown_key(name, "at the top level", known);
  const auto owner = std::ranges::find_if(sections, [&](const ConfigSection& section) {
    return std::ranges::find(section.fields, name, &OptionField::name) != section.fields.end();
  });
  if (owner != sections.end()) {
    error.message =
        concat("'", name, "' is at the top level; it belongs in a section: ", owner->name, ": {",
               name, ": ...}");
  }
  return error;
}

Result<OptionField*> find_field(std::string_view name, ConfigSection& section) {
  std::vector<std::string> known;
  for (OptionField& field : section.fields) {
    if (field.name == name) return &field;
    known.push_back(field.name);
  }
  return unknown_key(name, concat("in section '", section.name, "'"), known);
}

// A map, or a list of such maps.
Json one_or_several(Json one) {
  Json item = one;
  item.erase("description");
  item["type"] = "object";
  Json several = {{"description", "Several of them"}, {"type", "array"}, {"minItems", 1}};
  several["items"] = std::move(item);
  return {{"oneOf", Json::array({std::move(one), std::move(several)})}};
}

Result<void> read_section(const YamlNode& node, ConfigSection& section) {
  const std::string where = concat("section '", section.name, "'");
  if (!section.word.empty() && node.kind == YamlNode::Kind::kScalar) {
    return set_field(node, *std::ranges::find(section.fields, section.word, &OptionField::name));
  }
  if (!section.one_more || node.kind != YamlNode::Kind::kList) {
    return set_fields(node, where, section.fields);
  }
  if (node.values.empty()) {
    return placed({ErrorCode::kBadValue, where + ": the list is empty, expected a drive or more"},
                  node);
  }
  for (std::size_t i = 0; i < node.values.size(); ++i) {
    std::vector<OptionField> fields = i == 0 ? section.fields : section.one_more();
    SIGHTLINE_TRY(set_fields(node.values[i], concat(where, ", drive ", i + 1), fields));
  }
  return {};
}

Result<void> read_sections(const std::string& text, std::vector<ConfigSection>& sections) {
  SIGHTLINE_ASSIGN(const YamlNode root, parse_yaml(text));
  if (root.kind != YamlNode::Kind::kMap) {
    return Error{ErrorCode::kMalformedText,
                 "a configuration is a map of sections, such as mapping: {scans: FOLDER}; "
                 "`sightline init FOLDER -o drive.yaml` writes one",
                 "", "line 1, column 1"};
  }
  for (std::size_t i = 0; i < root.keys.size(); ++i) {
    const Result<ConfigSection*> section = find_section(root.keys[i].scalar, sections);
    if (!section) return placed(section.error(), root.keys[i]);
    if (!(*section)->schema.empty()) continue;
    SIGHTLINE_TRY(read_section(root.values[i], **section));
  }
  return {};
}

fs::path common_folder(const fs::path& a, const fs::path& b) {
  const auto end = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  fs::path common;
  for (auto part = a.begin(); part != end; ++part) common /= *part;
  return common;
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
  SIGHTLINE_ASSIGN(const std::string text, read_yaml_text(file));
  const Result<void> read = read_sections(text, sections);
  if (!read) return in_file(read.error(), file.string());
  return {};
}

Result<void> set_override(std::string_view assignment, std::vector<ConfigSection>& sections) {
  const std::size_t equals = assignment.find('=');
  const std::size_t dot = assignment.substr(0, equals).find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos) {
    return Error{ErrorCode::kBadArgument,
                 concat("found '", assignment, "', expected section.key=value"), "--set"};
  }
  SIGHTLINE_ASSIGN(ConfigSection* const section, find_section(assignment.substr(0, dot), sections));
  SIGHTLINE_ASSIGN(OptionField* const field,
                   find_field(assignment.substr(dot + 1, equals - dot - 1), *section));
  return set_from_text(*field, assignment.substr(equals + 1));
}

std::string to_yaml(const std::vector<ConfigSection>& sections) {
  std::string text;
  for (const ConfigSection& section : sections) {
    if (section.fields.empty()) continue;
    text += concat("# ", section.help, "\n", section.name, ":\n");
    for (const OptionField& field : section.fields) {
      text += concat("  # ", field.help, "\n  ", field.name, ": ", json_text(field), "\n");
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
    Json one = {{"description", section.help},
                {"type", Json::array({"object", "null"})},
                {"additionalProperties", false},
                {"properties", Json::parse(properties_schema(section.fields))}};
    if (section.one_more) one = one_or_several(std::move(one));
    if (!section.word.empty()) one["type"].push_back("string");
    root["properties"][section.name] = std::move(one);
  }
  return json_text(root);
}

std::vector<std::string> place_names(const std::vector<std::string>& files) {
  std::vector<fs::path> paths;
  for (const std::string& file : files) paths.push_back(fs::absolute(file).lexically_normal());
  fs::path common = paths.empty() ? fs::path() : paths.front().parent_path();
  for (const fs::path& path : paths) common = common_folder(common, path.parent_path());
  std::vector<std::string> names;
  for (const fs::path& path : paths) {
    names.push_back(path.lexically_relative(common).generic_string());
  }
  return names;
}

}  // namespace sightline
