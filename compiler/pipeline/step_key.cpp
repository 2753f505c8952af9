#include "compiler/pipeline/step_key.h"

#include <algorithm>
#include <vector>

namespace sightline {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

// On one line, and different for different texts.
std::string on_one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    if (c == '\\') {
      line += "\\\\";
    } else if (c == '\n') {
      line += "\\n";
    } else {
      line += c;
    }
  }
  return line;
}

// Where inputs may be missing or repeated, how many each parameter of the pass has: a line, or
// nothing.
std::string counts_of_inputs(const PassStep& step) {
  const auto is_one = [](std::size_t count) { return count == 1; };
  if (std::ranges::all_of(step.input_counts, is_one)) return "";
  std::string line = "inputs by parameter =";
  for (const std::size_t count : step.input_counts) line += " " + std::to_string(count);
  return line + "\n";
}

// Of how the step works and what its inputs hold. Their names are left out: equal contents give an
// equal output, whichever recording of a configuration they come from.
Digest digest_of(const Plan& plan, const PassStep& step, const Digest& way,
                 const std::function<Digest(std::size_t artifact)>& key_of_input) {
  DigestBuilder builder;
  builder.add(way);
  builder.add(counts_of_inputs(step));
  for (const std::size_t input : step.inputs) {
    builder.add(plan.artifact({input}).type->name);
    builder.add(key_of_input(input));
  }
  return builder.finish();
}

}  // namespace

StepKey step_key(const Plan& plan, const PassStep& step, std::uint64_t seed,
                 const std::function<Digest(std::size_t artifact)>& key_of_input) {
  const ArtifactType& output = *plan.artifact({step.output}).type;
  StepKey key;
  key.record = "pass version = " + std::to_string(step.version) + "\n";
  key.record += "encoding version of " + std::string(output.name) + " = " +
                std::to_string(output.version) + "\n";
  key.record += "seed = " + std::to_string(seed) + "\n";
  for (const auto& [name, value] : step.options) {
    key.record += "option " + name + " = " + on_one_line(value) + "\n";
  }
  DigestBuilder way;
  way.add(pass_of(step));
  way.add(std::string_view(key.record));
  key.way = way.finish();
  for (const std::size_t input : step.inputs) {
    key.record +=
        "input " + plan.artifact({input}).name + " = " + to_hex(key_of_input(input)) + "\n";
  }
  key.record += counts_of_inputs(step);
  key.key = digest_of(plan, step, key.way, key_of_input);
  return key;
}

Digest part_key(const StepKey& step, const PartName& part) {
  DigestBuilder builder;
  if (part.content) {
    builder.add("part of content");
    builder.add(step.way);
    builder.add(*part.content);
  } else {
    builder.add("part of number");
    builder.add(step.key);
    builder.add(std::to_string(part.number));
  }
  return builder.finish();
}

std::string reason_to_run(const std::string& before, const std::string& now) {
  if (before.empty()) return "never ran here";
  const std::vector<std::string> old_lines = lines_of(before);
  std::string reason;
  for (const std::string& line : lines_of(now)) {
    if (std::ranges::find(old_lines, line) != old_lines.end()) continue;
    const std::string name = line.substr(0, line.find(" = "));
    const auto was = std::ranges::find_if(
        old_lines, [&](const std::string& old_line) { return old_line.starts_with(name + " = "); });
    if (!reason.empty()) reason += "; ";
    if (name.starts_with("input ")) {
      reason += name + " changed";
    } else if (was == old_lines.end()) {
      reason += "new: " + line;
    } else {
      reason +=
          name + " was " + was->substr(name.size() + 3) + ", is " + line.substr(name.size() + 3);
    }
  }
  return reason.empty() ? "its result is not in the cache any more" : reason;
}

}  // namespace sightline
