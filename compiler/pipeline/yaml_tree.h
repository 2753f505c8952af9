#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// A YAML document as plain values, each with the line that it stands in.
struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  int line = 1;
  std::string scalar;            // as written, without quotes
  std::vector<YamlNode> keys;    // of a map, in the order of the file
  std::vector<YamlNode> values;  // of a map, one per key; or of a list

  // The value of a key, or nullptr.
  [[nodiscard]] const YamlNode* find(std::string_view key) const;
  [[nodiscard]] std::string place() const { return "line " + std::to_string(line); }
};

// Error: malformed-text with its line, also for a key that a map has twice, for a second document,
// and for documents that are nested or repeat themselves beyond all use.
Result<YamlNode> parse_yaml(const std::string& text);

// No configuration is longer: a longer text is malformed before it is parsed.
inline constexpr std::size_t kLargestYaml = std::size_t{1} << 20;

// The text of a file for parse_yaml. Errors: those of open_regular_file; malformed-text where it is
// too long.
Result<std::string> read_yaml_text(const std::filesystem::path& file);

}  // namespace sightline
