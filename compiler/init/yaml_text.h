#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace sightline {

// The text of a configuration with comments, and paths as they are seen from its folder.
class YamlText {
 public:
  // `folder`: absolute, of the file.
  explicit YamlText(std::filesystem::path folder);

  // Broken into lines of at most 100 characters.
  void comment(const std::string& text, const std::string& indent = "");
  // One that is written for every drive is read once.
  void comment_once(const std::string& text, const std::string& indent);
  void line(const std::string& text);

  // Beneath the file's folder relative, elsewhere absolute: then file and recordings may each move.
  [[nodiscard]] std::string path(const std::filesystem::path& absolute) const;
  // A plain scalar where YAML reads it back as it stands.
  static std::string scalar(const std::string& value);
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::filesystem::path folder_;
  std::string text_;
  std::set<std::string> said_;
};

}  // namespace sightline
