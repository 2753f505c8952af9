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

// Goes through the steps in running order.
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

}  // namespace sightline::golden
