#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "passes/pass/options.h"

// Options and YAML. Errors have line and column; the caller adds the file.

namespace sightline {

// A YAML document as plain values, each with its place in the text.
struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  int line = 1;
  int column = 0;                // from 1, in bytes; 0: not known
  std::string scalar;            // as written, without quotes
  std::vector<YamlNode> keys;    // of a map, in the order of the file
  std::vector<YamlNode> values;  // of a map, one per key; or of a list

  // The value of a key, or nullptr.
  [[nodiscard]] const YamlNode* find(std::string_view key) const;
  // "line 3, column 9"
  [[nodiscard]] std::string place() const;
};

// Error: malformed-text with its line and column, also for a key that a map has twice, for a second
// document, and for documents that are nested or repeat themselves beyond all use.
Result<YamlNode> parse_yaml(const std::string& text);

// No configuration is longer: a longer text is malformed before it is parsed.
inline constexpr std::size_t kLargestYaml = std::size_t{1} << 20;

// The text of a file for parse_yaml. Errors: those of open_regular_file; malformed-text where it is
// too long.
Result<std::string> read_yaml_text(const std::filesystem::path& file);

// One field from a scalar, or from a list of scalars. Error: bad-value.
Result<void> set_field(const YamlNode& node, OptionField& field);

// Every field that a map names; keys in `others` are left to the caller, and no value at all sets
// nothing. `where` is "section 'gate'". Errors: bad-value, unknown-key with the nearest known one.
Result<void> set_fields(const YamlNode& node, const std::string& where,
                        std::vector<OptionField>& fields,
                        const std::vector<std::string>& others = {});

// unknown-key; `where` is "in section 'gate'" or "at the top level".
Error unknown_key(std::string_view key, std::string_view where,
                  const std::vector<std::string>& known);

Error placed(Error error, const YamlNode& node);

// The value of a field, in the words of both YAML and JSON.
std::string json_text(const OptionField& field);

// JSON Schema (draft 7) of a map of these fields, as "properties" holds it: an object with a schema
// for each name. The values that the fields hold now are its defaults.
std::string properties_schema(const std::vector<OptionField>& fields);

}  // namespace sightline
