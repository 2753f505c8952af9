#include "compiler/pipeline/yaml_tree.h"

#include <yaml-cpp/yaml.h>

#include <map>

// All that knows yaml-cpp.

namespace sightline {
namespace {

// Aliases can make a short text endless.
constexpr int kMostDepth = 32;
constexpr std::size_t kMostNodes = 1'000'000;

class TreeBuilder {
 public:
  YamlNode build(const YAML::Node& from, int depth) {
    if (depth > kMostDepth || ++count_ > kMostNodes) {
      throw YAML::Exception(from.Mark(), "nested too deep or too large");
    }
    YamlNode node;
    node.line = from.Mark().line + 1;
    if (from.IsScalar()) {
      node.kind = YamlNode::Kind::kScalar;
      node.scalar = from.Scalar();
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
  // yaml-cpp keeps all of them, and whoever looks one up gets any.
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
};

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].kind == Kind::kScalar && keys[i].scalar == key) return &values[i];
  }
  return nullptr;
}

Result<YamlNode> parse_yaml(const std::string& text) {
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    for (std::size_t i = 1; i < documents.size(); ++i) {
      if (documents[i].IsNull()) continue;  // a line of --- at the end
      throw YAML::Exception(documents[i].Mark(), "a second document begins here, expected one");
    }
    return TreeBuilder().build(documents.empty() ? YAML::Node() : documents.front(), 0);
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, "not YAML: " + exception.msg, "",
                 "line " + std::to_string(exception.mark.line + 1)};
  }
}

}  // namespace sightline
