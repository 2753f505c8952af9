#include "tests/golden/compare.h"

#include <algorithm>
#include <set>

#include "tests/golden/golden_file.h"

namespace sightline::golden {
namespace {

constexpr const char* kUpdate = "run tests/update_golden.sh and review the diff";

std::string outside_verdict(const StepOutput& output) {
  if (output.step == "inputs") {
    return "inputs: what the passes are given changed: the town's generator, its configuration or "
           "how recordings are read";
  }
  return output.step + ": bytes changed, what they are made of did not: find out why, or " +
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

std::string files_without_step(const RunOutput& run, const GoldenFiles& kept) {
  const GoldenFiles made = golden_files(run);
  std::string text;
  for (const auto& [name, content] : kept) {
    if (!made.contains(name)) text += name + ": belongs to no step: " + kUpdate + "\n";
  }
  return text;
}

}  // namespace

GoldenFiles golden_files(const RunOutput& run) {
  GoldenFiles files;
  for (const StepOutput& output : run.steps) files[file_name(output.step)] = golden_text(output);
  return files;
}

std::string compare(const RunOutput& run, const GoldenFiles& kept) {
  std::string causes;
  std::string followers;
  std::set<std::string> changed;  // artifacts
  for (const StepOutput& output : run.steps) {
    const std::string name = file_name(output.step);
    const std::string made = golden_text(output);
    const std::string golden = kept.contains(name) ? kept.at(name) : "";
    if (made == golden) continue;
    const bool output_changed = read_head(golden).digest != to_hex(output.digest);
    const bool is_after = std::ranges::any_of(
        output.inputs, [&](const std::string& input) { return changed.contains(input); });
    if (output_changed) changed.insert(output.artifact);
    if (output_changed && is_after) {
      followers += (followers.empty() ? "" : ", ") + output.step;
      continue;
    }
    causes += verdict(output, golden, output_changed) + "\n  " + run.name + "/" + name +
              ", as kept (-) and as made now (+):\n" + first_differences(golden, made);
  }
  if (!followers.empty()) causes += "after it: " + followers + "\n";
  return causes + files_without_step(run, kept);
}

}  // namespace sightline::golden
