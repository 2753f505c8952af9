#include "compiler/pipeline/yaml_tree.h"

#include <yaml-cpp/yaml.h>

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
    }
    return node;
  }

 private:
  std::size_t count_ = 0;
};

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  for (std::size_t i = keys.size(); i-- > 0;) {
    if (keys[i].kind == Kind::kScalar && keys[i].scalar == key) return &values[i];
  }
  return nullptr;
}

Result<YamlNode> parse_yaml(const std::string& text) {
  try {
    return TreeBuilder().build(YAML::Load(text), 0);
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformedText, "not YAML: " + exception.msg, "",
                 "line " + std::to_string(exception.mark.line + 1)};
  }
}

}  // namespace sightline
