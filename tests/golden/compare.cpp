#include "tests/golden/compare.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <sstream>

namespace sightline::golden {
namespace {

constexpr const char* kUpdate = "run tests/update_golden.sh and review the diff";

std::string outside_verdict(const StepOutput& output) {
  if (output.step == "inputs") {
    return "inputs: what the passes are given changed: the town's generator, its configuration or "
           "how recordings are read";
  }
  return output.step +
         ": bytes changed, what they are made of did not: emit-map or the encoding of maps "
         "changed; find out why, or " +
         kUpdate;
}

std::string verdict(const StepOutput& output, const std::string& kept, bool output_changed) {
  if (kept.empty()) return output.step + ": no golden file yet: " + kUpdate;
  if (output.version_constant.empty()) return outside_verdict(output);
  const GoldenHead head = read_head(kept);
  const std::string was = std::to_string(head.version);
  const std::string is = std::to_string(output.version);
  if (!output_changed && head.version == output.version) {
    return output.step + ": its dump changed, the artifact did not: " + kUpdate;
  }
  if (!output_changed) {
    return output.step + ": version " + was + " became " + is +
           ", the output is the same here: " + kUpdate;
  }
  if (head.version != output.version) {
    return output.step + ": output changed and its version went from " + was + " to " + is + ": " +
           kUpdate;
  }
  if (head.encoding != output.encoding) {
    return output.step + ": its output is now encoded as '" + output.encoding + "', was '" +
           head.encoding + "': " + kUpdate;
  }
  return output.step + ": output changed, its version " + is + " did not: raise " +
         output.version_constant + " or find out why";
}

class Comparison {
 public:
  explicit Comparison(const GoldenFiles& kept) : kept_(kept) {}

  void add(const RunOutput& run, const StepOutput& output) {
    const std::string file = run.name + "/" + file_name(output.step);
    const std::string made = golden_text(output);
    const std::string golden = kept_.contains(file) ? kept_.at(file) : "";
    if (made == golden) return;
    const bool output_changed = read_head(golden).digest != to_hex(output.digest);
    const bool is_after = std::ranges::any_of(
        output.inputs, [&](const std::string& input) { return changed_.contains(input); });
    if (output_changed) changed_.insert(output.artifact);
    if (output_changed && is_after) {
      followers_ += (followers_.empty() ? "" : ", ") + run.name + "/" + output.step;
      return;
    }
    causes_ += verdict(output, golden, output_changed) + "\n  " + file +
               ", as kept (-) and as made now (+):\n" + first_differences(golden, made);
  }
  [[nodiscard]] std::string text() const {
    return followers_.empty() ? causes_ : causes_ + "after it: " + followers_ + "\n";
  }

 private:
  const GoldenFiles& kept_;
  std::set<std::string> changed_;  // artifacts
  std::string causes_;
  std::string followers_;
};

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

GoldenFiles golden_files(const std::vector<RunOutput>& runs) {
  GoldenFiles files;
  for (const RunOutput& run : runs) {
    for (const StepOutput& output : run.steps) {
      files[run.name + "/" + file_name(output.step)] = golden_text(output);
    }
  }
  return files;
}

std::string compare(const std::vector<RunOutput>& runs, const GoldenFiles& kept) {
  Comparison comparison(kept);
  for (const RunOutput& run : runs) {
    for (const StepOutput& output : run.steps) comparison.add(run, output);
  }
  std::string text = comparison.text();
  const GoldenFiles made = golden_files(runs);
  for (const auto& [file, golden] : kept) {
    if (!made.contains(file)) text += file + ": belongs to no step: " + kUpdate + "\n";
  }
  return text;
}

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
