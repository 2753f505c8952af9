#include "tests/golden/golden_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

namespace sightline::golden {
namespace {

constexpr std::size_t kMostRows = 24;
constexpr std::size_t kMostDifferences = 4;   // lines that a message shows
constexpr std::size_t kMostCharacters = 160;  // of such a line

std::string text_of(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) return std::to_string(*whole);
  std::array<char, 32> number{};
  std::snprintf(number.data(), number.size(), "%.9g", std::get<double>(cell));
  return number.data();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string value_of(const std::string& name, const std::vector<std::string>& lines) {
  const std::string begin = name + ": ";
  const auto line = std::ranges::find_if(
      lines, [&](const std::string& candidate) { return candidate.starts_with(begin); });
  return line == lines.end() ? "" : line->substr(begin.size());
}

std::string shortened(const std::string& line) {
  return line.size() <= kMostCharacters ? line : line.substr(0, kMostCharacters) + " ...";
}

std::string rows_text(const Table& table) {
  const std::size_t count = table.rows.size();
  const std::size_t shown = std::min(count, kMostRows);
  std::string text =
      "rows: " + std::to_string(count) + ", shown: " + std::to_string(shown) + "\nrow";
  for (const std::string& column : table.columns) text += "," + column;
  text += "\n";
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t row = shown == 1 ? 0 : i * (count - 1) / (shown - 1);
    text += std::to_string(row);
    for (const Cell& cell : table.rows[row]) text += "," + text_of(cell);
    text += "\n";
  }
  return text;
}

}  // namespace

std::string file_name(const std::string& step) {
  std::string name = step;
  std::ranges::replace(name, ':', '.');
  return name + ".txt";
}

std::string golden_text(const StepOutput& output) {
  std::string text = "step: " + output.step + "\n";
  if (!output.version_constant.empty()) {
    text += "version: " + std::to_string(output.version) + "\nartifact: " + output.artifact +
            "\nencoding: " + output.encoding + "\n";
  }
  text += "sha256: " + to_hex(output.digest) + "\n";
  for (const auto& [name, value] : output.table.facts) text += name + ": " + text_of(value) + "\n";
  return output.table.columns.empty() ? text : text + rows_text(output.table);
}

GoldenHead read_head(const std::string& text) {
  const std::vector<std::string> lines = lines_of(text);
  GoldenHead head;
  const std::string version = value_of("version", lines);
  std::istringstream(version) >> head.version;
  head.encoding = value_of("encoding", lines);
  head.digest = value_of("sha256", lines);
  return head;
}

std::string first_differences(const std::string& kept, const std::string& made) {
  const std::vector<std::string> old_lines = lines_of(kept);
  const std::vector<std::string> new_lines = lines_of(made);
  std::string text;
  std::size_t shown = 0;
  for (std::size_t i = 0; i < std::max(old_lines.size(), new_lines.size()); ++i) {
    const std::string old_line = i < old_lines.size() ? old_lines[i] : "";
    const std::string new_line = i < new_lines.size() ? new_lines[i] : "";
    if (old_line == new_line) continue;
    if (shown++ == kMostDifferences) return text + "  ...\n";
    if (!old_line.empty()) text += "  - " + shortened(old_line) + "\n";
    if (!new_line.empty()) text += "  + " + shortened(new_line) + "\n";
  }
  return text;
}

}  // namespace sightline::golden
