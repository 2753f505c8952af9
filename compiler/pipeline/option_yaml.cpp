#include "compiler/pipeline/option_yaml.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/yaml.h>
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/base/files/regular_file.h"

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

// Aliases can make a short text endless.
constexpr int kMostDepth = 32;
constexpr std::size_t kMostNodes = 1'000'000;
constexpr std::size_t kMostText = std::size_t{1} << 26U;  // of all scalars, bytes

class TreeBuilder {
 public:
  YamlNode build(const YAML::Node& from, int depth) {
    if (depth > kMostDepth || ++count_ > kMostNodes || text_size_ > kMostText) {
      throw YAML::Exception(from.Mark(), "nested too deep or too large");
    }
    YamlNode node;
    node.line = from.Mark().line + 1;
    node.column = from.Mark().column + 1;
    if (from.IsScalar()) {
      node.kind = YamlNode::Kind::kScalar;
      node.scalar = from.Scalar();
      text_size_ += node.scalar.size();
    } else if (from.IsSequence()) {
      node.kind = YamlNode::Kind::kList;
      for (const YAML::Node& item : from) node.values.push_back(build(item, depth + 1));
    } else if (from.IsMap()) {
      node.kind = YamlNode::Kind::kMap;
      for (const auto& entry : from) {
        node.keys.push_back(build(entry.first, depth + 1));
        node.values.push_back(build(entry.second, depth + 1));
      }
      refuse_second_keys(node);
    }
    return node;
  }

 private:
  // yaml-cpp keeps all of them, and a look-up returns any.
  static void refuse_second_keys(const YamlNode& map) {
    std::map<std::string_view, int> lines;
    for (const YamlNode& key : map.keys) {
      if (key.kind != YamlNode::Kind::kScalar) continue;
      const auto [first, is_new] = lines.emplace(key.scalar, key.line);
      if (is_new) continue;
      YAML::Mark mark;
      mark.line = key.line - 1;
      mark.column = key.column - 1;
      throw YAML::Exception(
          mark, concat("a second '", key.scalar, "'; the first one is in line ", first->second));
    }
  }

  std::size_t count_ = 0;
  std::size_t text_size_ = 0;
};

// Counts the documents of a text without keeping them: yaml-cpp finds documents without end where a
// text begins with "," or the like, and would load them all.
class DocumentCounter : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& mark) override {
    constexpr int kMostDocuments = 100;  // lines of --- at the end
    if (++count_ > kMostDocuments) throw YAML::Exception(mark, "documents without end");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { add(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {
    last_scalar_ = mark;
    add(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/,
                       YAML::anchor_t /*anchor*/, YAML::EmitterStyle::value /*style*/) override {
    add(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    add(mark);
  }
  void OnMapEnd() override {}

  [[nodiscard]] const YAML::Mark& last_scalar() const { return last_scalar_; }

 private:
  void add(const YAML::Mark& mark) const {
    if (count_ > 1) throw YAML::Exception(mark, "a second document begins here; expected one");
  }

  int count_ = 0;
  YAML::Mark last_scalar_;
};

void refuse_second_document(const std::string& text, DocumentCounter& counter) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  while (parser.HandleNextDocument(counter)) continue;
}

// "line 3, column 9", both from 1; no column where it is not known.
std::string place_text(int line, int column) {
  const std::string text = concat("line ", line);
  return column > 0 ? concat(text, ", column ", column) : text;
}

// What was probably meant where yaml-cpp understands nothing.
std::string hint(const YAML::Exception& exception, const std::string& text) {
  const bool has_tab = text.starts_with('\t') || text.find("\n\t") != std::string::npos;
  if (has_tab) return "; a line begins with a tab: write blanks";
  if (exception.msg == YAML::ErrorMsg::MAP_VALUE) {
    return "; the keys of a section begin in the same column, and a blank follows each colon";
  }
  return "";
}

// Whether the last scalar of a text begins with a quote that is never closed: yaml-cpp takes all of
// the text behind it for its value.
bool is_unclosed(const std::string& text, const YAML::Mark& last_scalar) {
  if (last_scalar.pos < 0 || static_cast<std::size_t>(last_scalar.pos) >= text.size()) return false;
  const auto begin = static_cast<std::size_t>(last_scalar.pos);
  const char quote = text[begin];
  if (quote != '"' && quote != '\'') return false;
  for (std::size_t i = begin + 1; i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\') {
      ++i;  // whatever it escapes
    } else if (text[i] == quote) {
      const bool is_escaped = quote == '\'' && i + 1 < text.size() && text[i + 1] == quote;
      if (!is_escaped) return false;
      ++i;
    }
  }
  return true;
}

Error unclosed(const YAML::Mark& quote) {
  return {ErrorCode::kMalformedText, "not YAML: this quote is not closed", "",
          place_text(quote.line + 1, quote.column + 1)};
}

Error too_large() {
  return {ErrorCode::kMalformedText,
          concat("the text is longer than ", kLargestYaml, " bytes; a configuration is shorter")};
}

}  // namespace

Error unknown_key(std::string_view key, std::string_view where,
                  const std::vector<std::string>& known) {
  std::string message = concat("unknown key '", key, "' ", where);
  const std::string near = nearest_name(key, known);
  if (!near.empty()) {
    message += concat("; did you mean '", near, "'?");
  } else {
    message += "; known keys:";
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
    return placed({ErrorCode::kBadValue, concat(where, " must be a map of keys", example)}, node);
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

// A path need not be UTF-8; what is none of it is replaced.
std::string json_text(const OptionField& field) {
  return json_value(field).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string properties_schema(const std::vector<OptionField>& fields) {
  Json properties = Json::object();
  for (const OptionField& field : fields) properties[field.name] = field_schema(field);
  return properties.dump();
}

const YamlNode* YamlNode::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].kind == Kind::kScalar && keys[i].scalar == key) return &values[i];
  }
  return nullptr;
}

std::string YamlNode::place() const { return place_text(line, column); }

Result<std::string> read_yaml_text(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(std::string text, read_beginning(file.string(), kLargestYaml + 1));
  if (text.size() > kLargestYaml) return in_file(too_large(), file.string());
  return text;
}

Result<YamlNode> parse_yaml(const std::string& text) {
  if (text.size() > kLargestYaml) return too_large();
  DocumentCounter counter;
  try {
    refuse_second_document(text, counter);
    if (is_unclosed(text, counter.last_scalar())) return unclosed(counter.last_scalar());
    return TreeBuilder().build(YAML::Load(text), 0);
  } catch (const YAML::Exception& exception) {
    if (is_unclosed(text, counter.last_scalar())) return unclosed(counter.last_scalar());
    return Error{ErrorCode::kMalformedText,
                 concat("not YAML: ", exception.msg, hint(exception, text)), "",
                 place_text(exception.mark.line + 1, exception.mark.column + 1)};
  }
}

}  // namespace sightline
