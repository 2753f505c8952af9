#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/pipeline/plan.h"
#include "formats/base/result.h"

// The configuration as sections of described fields: reading YAML, single overrides, the published
// JSON Schema and the effective configuration all work from the same description.

namespace sightline {

// One top-level key of the file. The fields point into the configuration that made the section.
struct ConfigSection {
  std::string name;  // "build-ndt"
  std::string help;
  std::vector<OptionField> fields;
  // JSON Schema of a section that is no list of fields; read_yaml passes it over: another reader's.
  std::string schema = {};
  std::shared_ptr<void> options = {};  // what the fields point into, where no other object holds it
  // Where the section may be a list of such maps: the fields of one more of them. `fields` are
  // those of the first.
  std::function<std::vector<OptionField>()> one_more = {};
  // The key that a section of one word stands for: `route: lanes.osm`. Empty: it has to be a map.
  std::string word = {};
};

// The sections of the passes in a plan, with their defaults.
std::vector<ConfigSection> sections_of(const Plan& plan);

// What sections of passes hold now.
PassSettings settings_of(const std::vector<ConfigSection>& sections);

// Sets every field that the YAML file names. An unknown section or key is unknown-key with the
// nearest known one; errors carry the file and "line N".
Result<void> read_yaml(const std::filesystem::path& file, std::vector<ConfigSection>& sections);

// Sets one field from "section.key=value". Errors: bad-argument, unknown-key, bad-value.
Result<void> set_override(std::string_view assignment, std::vector<ConfigSection>& sections);

// Every value as YAML that read_yaml reads back; a comment above each key says what it is.
std::string to_yaml(const std::vector<ConfigSection>& sections);

// JSON Schema (draft 7) of the file; the values that the fields hold now are its defaults.
std::string to_json_schema(const std::vector<ConfigSection>& sections);

// What the places of these configurations are called in a model's card: each file's path below the
// deepest folder that holds all of them, so that the same places in another folder have the same
// names. "/data/north/town.yaml", "/data/south/town.yaml": "north/town.yaml", "south/town.yaml".
std::vector<std::string> place_names(const std::vector<std::string>& files);

}  // namespace sightline
