#include "compiler/pipeline/option_yaml.h"

#include <algorithm>

namespace sightline {
namespace {

// A scalar as it stands, a sequence of scalars as "a, b, c"; anything deeper is no value of ours.
Result<std::string> text_of(const YamlNode& node) {
  if (node.kind != YamlNode::Kind::kList && node.kind != YamlNode::Kind::kMap) return node.scalar;
  if (node.kind == YamlNode::Kind::kMap) {
    return Error{ErrorCode::kBadValue, "found a map, expected a value or a list of values"};
  }
  std::string text;
  for (const YamlNode& item : node.values) {
    if (item.kind != YamlNode::Kind::kScalar) {
      return Error{ErrorCode::kBadValue, "found a nested list, expected a list of values"};
    }
    text += (text.empty() ? "" : ", ") + item.scalar;
  }
  return text;
}

}  // namespace

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
  return {ErrorCode::kUnknownKey, message};
}

Error placed(Error error, const YamlNode& node) {
  error.place = node.place();
  return error;
}

Result<void> set_field(const YamlNode& node, OptionField& field) {
  const Result<std::string> text = text_of(node);
  if (!text) return placed(text.error(), node);
  const Result<void> set = set_from_text(field, *text);
  if (!set) return placed(set.error(), node);
  return {};
}

Result<void> set_fields(const YamlNode& node, const std::string& where,
                        std::vector<OptionField>& fields, const std::vector<std::string>& others) {
  if (node.kind == YamlNode::Kind::kNull) return {};
  if (node.kind != YamlNode::Kind::kMap) {
    const auto scans = std::ranges::find(fields, "scans", &OptionField::name);
    const std::string example = scans == fields.end() ? "" : ", such as {scans: FOLDER}";
    return placed({ErrorCode::kBadValue, where + " must be a map of keys" + example}, node);
  }
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const YamlNode& key = node.keys[i];
    if (std::ranges::find(others, key.scalar) != others.end()) continue;
    const auto field = std::ranges::find(fields, key.scalar, &OptionField::name);
    if (field == fields.end()) {
      std::vector<std::string> known = others;
      for (const OptionField& each : fields) known.push_back(each.name);
      return placed(unknown_key(key.scalar, "in " + where, known), key);
    }
    SIGHTLINE_TRY(set_field(node.values[i], *field));
  }
  return {};
}

}  // namespace sightline
