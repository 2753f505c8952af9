#include "compiler/pipeline/yaml_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <sstream>

#include "formats/base/files/regular_file.h"

// All that knows yaml-cpp.

namespace sightline {
namespace {

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
      throw YAML::Exception(mark, "a second '" + key.scalar + "', the first stands in line " +
                                      std::to_string(first->second));
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

 private:
  void add(const YAML::Mark& mark) const {
    if (count_ > 1) throw YAML::Exception(mark, "a second document begins here, expected one");
  }

  int count_ = 0;
};

void refuse_second_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentCounter counter;
  while (parser.HandleNextDocument(counter)) continue;
}

// What people mean to write where yaml-cpp understands nothing.
std::string hint(const YAML::Exception& exception, const std::string& text) {
  const bool has_tab = text.starts_with('\t') || text.find("\n\t") != std::string::npos;
  if (has_tab) return "; a line begins with a tab, YAML takes blanks alone";
  if (exception.msg == YAML::ErrorMsg::MAP_VALUE) {
    return "; keys of one section begin in one column, each with a blank behind its colon";
  }
  return "";
}

Error too_large() {
  return {ErrorCode::kMalformedText,
          "more than " + std::to_string(kLargestYaml) + " bytes, which no configuration has"};
}

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].kind == Kind::kScalar && keys[i].scalar == key) return &values[i];
  }
  return nullptr;
}

Result<std::string> read_yaml_text(const std::filesystem::path& file) {
  SIGHTLINE_ASSIGN(std::string text, read_beginning(file.string(), kLargestYaml + 1));
  if (text.size() > kLargestYaml) return in_file(too_large(), file.string());
  return text;
}

Result<YamlNode> parse_yaml(const std::string& text) {
  if (text.size() > kLargestYaml) return too_large();
  try {
    refuse_second_document(text);
    return TreeBuilder().build(YAML::Load(text), 0);
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, "not YAML: " + exception.msg + hint(exception, text),
                 "", "line " + std::to_string(exception.mark.line + 1)};
  }
}

}  // namespace sightline
