#include "compiler/init/yaml_text.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& value) {
  return !value.empty() && value.find_first_not_of("-.0123456789") == std::string::npos;
}

}  // namespace

YamlText::YamlText(fs::path folder) : folder_(std::move(folder)) {}

void YamlText::comment(const std::string& text, const std::string& indent) {
  constexpr std::size_t kWidth = 100;
  std::string line = indent + "#";
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (line.size() + 1 + end - begin > kWidth && line.size() > indent.size() + 1) {
      text_ += line + "\n";
      line = indent + "#";
    }
    line += " " + text.substr(begin, end - begin);
    begin = end + 1;
  }
  text_ += line + "\n";
}

void YamlText::comment_once(const std::string& text, const std::string& indent) {
  if (said_.insert(text).second) comment(text, indent);
}

void YamlText::line(const std::string& text) { text_ += text + "\n"; }

std::string YamlText::path(const fs::path& absolute) const {
  const fs::path relative = absolute.lexically_relative(folder_);
  const bool is_beneath = !relative.empty() && *relative.begin() != "..";
  return is_beneath ? relative.string() : absolute.string();
}

std::string YamlText::scalar(const std::string& value) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/' || c == '+';
  };
  const bool may_begin = !value.empty() && value.front() != '-';
  if ((may_begin || is_number(value)) && std::ranges::all_of(value, is_plain)) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace sightline
